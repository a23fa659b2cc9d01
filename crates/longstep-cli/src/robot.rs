//! `longstep robot`: what can be learned from a robot without a plan.

mod environment;

use std::path::Path;

use anyhow::Result;
use longstep_files::read_text;
use longstep_llm::load_domain;
use longstep_robot::ros2::{self, Configuration};

use crate::arguments::{RobotCheckArguments, RobotCommand, domain_or_default};
use crate::exit_code::NOT_VALID;
use crate::inputs;
use crate::output::{Style, print_line, shell_word};
use crate::run::robot_exit_code;
use crate::show;

pub(crate) fn run(command: &RobotCommand) -> Result<u8> {
    match command {
        RobotCommand::Check(arguments) => check(arguments),
        RobotCommand::Environment(arguments) => environment::run(arguments),
    }
}

/// Compares `robot.toml` with a domain, then tries the connection. Findings are the result of the command and go to stdout.
fn check(arguments: &RobotCheckArguments) -> Result<u8> {
    let domain = load_domain(domain_or_default(arguments.domain.as_ref()))?;
    let world = match &arguments.env {
        Some(env) => Some(inputs::world(&domain, env, None)?),
        None => None,
    };
    let configuration = parsed(&arguments.file)?;
    let checked = ros2::check(&configuration, &domain, world.as_ref());
    for finding in &checked.mismatches {
        show::finding("error:".red().bold(), finding);
    }
    for finding in &checked.remarks {
        show::finding("warning:".yellow().bold(), finding);
    }
    let name = configuration.name().to_owned();
    if !checked.mismatches.is_empty() {
        let count = checked.mismatches.len();
        print_line!(
            "{name}: {count} mismatch{} with the domain `{}`",
            plural(count),
            domain.name
        );
        return Ok(NOT_VALID);
    }
    print_line!("{name}: fits the domain `{}`", domain.name);
    if arguments.offline {
        Ok(0)
    } else {
        Ok(connection(configuration, arguments, &domain, world.as_ref()))
    }
}

fn connection(
    configuration: Configuration,
    arguments: &RobotCheckArguments,
    domain: &longstep_core::model::Domain,
    world: Option<&longstep_core::environment::World>,
) -> u8 {
    let mut code = 0;
    for trial in ros2::trials(configuration, domain, world) {
        match trial.result {
            Ok(found) => print_line!("{}: {found}", trial.subject),
            Err(error) => {
                print_line!("{} {error}", "error:".red().bold());
                if let Some(hint) = error.hint().filter(|_| code == 0) {
                    show::hint(hint);
                }
                if code == 0 {
                    code = robot_exit_code(&error);
                }
            }
        }
    }
    if code == 0 {
        let robot = shell_word(format_args!("ros2:{}", arguments.file.display()));
        show::hint(&format!(
            "`longstep run PLAN.json --robot {robot}` shows what would be sent; `--live` sends it"
        ));
    }
    code
}

fn parsed(path: &Path) -> Result<Configuration> {
    Ok(Configuration::parse(&path.display().to_string(), &read_text(path)?)?)
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "es" }
}
