//! The nodes that are written for the shipped domains tick exactly the steps of their plans, in C++ and in Python.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use longstep_core::domain;
use longstep_core::model::Domain;
use longstep_core::plan::Node;
use longstep_core::plan::behavior_tree::nodes::{self, Language};
use longstep_core::plan::behavior_tree::{Guards, write};
use longstep_core::schedule;
use longstep_core::tree_peer::{End, Peer, Trouble};
use longstep_core::verify::{Purpose, VerifiedPlan};
use longstep_eval::suite;

use crate::workshop::{check_types, compiled, program, python, starter};
use crate::{choices, example, hostile};

/// The plans of one domain that are ticked, of each form.
const MOST: usize = 12;

fn shipped_domains() -> Vec<Domain> {
    let domains = domain::shipped_names().into_iter();
    domains.map(|name| domain::shipped(name).unwrap().unwrap()).collect()
}

/// Returns plans of the suites by their domain: sequences, branches and loops, and lanes.
fn plans_by_domain() -> BTreeMap<String, Vec<VerifiedPlan>> {
    let mut forms: BTreeMap<(String, usize), Vec<VerifiedPlan>> = BTreeMap::new();
    for name in suite::shipped_names() {
        let (domain, suite) = suite::load_shipped(name).unwrap().unwrap();
        for (plan, _) in suite.plans().unwrap() {
            let lanes = schedule::share(plan.world(), &plan, &Purpose::default()).map(|shared| shared.plan);
            let form = usize::from(!plan.plan().is_sequence());
            for (form, plan) in [(form, plan)].into_iter().chain(lanes.map(|lanes| (2, lanes))) {
                let own = forms.entry((domain.name.clone(), form)).or_default();
                if own.len() < MOST && plan.steps().len() > 1 {
                    own.push(plan);
                }
            }
        }
    }
    let mut plans: BTreeMap<String, Vec<VerifiedPlan>> = BTreeMap::new();
    for ((domain, _), own) in forms {
        plans.entry(domain).or_default().extend(own);
    }
    plans
}

/// Counts of what was ticked.
#[derive(Debug, Default)]
struct Count {
    plans: usize,
    branching: usize,
    lanes: usize,
    done: usize,
    failed: usize,
    halted: usize,
}

/// Ticks the plans of a domain with its program, without trouble and with each kind of it.
fn tick_all(program: &Path, plans: &[VerifiedPlan], count: &mut Count) {
    let folder = tempfile::tempdir().unwrap();
    let mut peer = Peer::start(program, folder.path()).unwrap();
    for plan in plans {
        count.plans += 1;
        let has_lanes = plan
            .plan()
            .body()
            .iter()
            .any(|node| matches!(node, Node::Parallel { .. }));
        count.lanes += usize::from(has_lanes);
        count.branching += usize::from(!has_lanes && !plan.plan().is_sequence());
        let mut choose = choices(count.plans);
        for guards in [Guards::None, Guards::Preconditions] {
            let xml = write(plan.world(), plan.plan(), guards).unwrap();
            let step = choose(plan.steps().len());
            let change = (guards == Guards::Preconditions).then_some(Trouble::Change(1 + step));
            let troubles = [
                Trouble::None,
                Trouble::None,
                Trouble::Failure(step),
                Trouble::Halt(step),
                Trouble::Exception(step),
            ];
            for trouble in troubles.into_iter().chain(change) {
                let end = peer.tick(plan, &xml, trouble, &mut choose);
                match end.unwrap_or_else(|error| panic!("{}, {trouble:?}: {error}\n{xml}", program.display())) {
                    End::Done => count.done += 1,
                    End::Failed => count.failed += 1,
                    End::Halted => count.halted += 1,
                    End::Endless => panic!("the plans of the suites end"),
                }
            }
        }
        let xml = write(plan.world(), plan.plan(), Guards::None).unwrap();
        let misspelt = xml.replacen("=\"&lt;", "x=\"&lt;", 1);
        assert!(peer.refusal(&misspelt).unwrap().contains('x'));
    }
}

fn assert_all_kinds(count: &Count) {
    assert!(count.plans > 40 && count.branching > 5 && count.lanes > 5, "{count:?}");
    assert!(count.done > 80 && count.failed > 80 && count.halted > 40, "{count:?}");
}

#[test]
#[ignore = "needs LONGSTEP_BEHAVIOR_TREES, which tools/peers/behavior_trees/build.sh prints"]
fn headers_of_the_shipped_domains_tick_the_steps_of_their_plans() {
    let folder = tempfile::tempdir().unwrap();
    let domains = shipped_domains();
    let text = [
        program(&domains, folder.path()),
        hostile::program(folder.path()),
        example::program(folder.path()),
        include_str!("main.cpp").replace(
            "int main(int, char** words) {",
            &example::main_of_all("int main(int, char** words) {"),
        ),
    ];
    let program = compiled(folder.path(), &text.concat());
    let mut count = Count::default();
    for (domain, plans) in plans_by_domain() {
        let own = starter(
            folder.path(),
            &format!("start-{domain}"),
            &[program.to_str().unwrap(), &domain],
        );
        tick_all(&own, &plans, &mut count);
    }
    println!("{count:?}");
    assert_all_kinds(&count);
    example::assert_runs(folder.path(), &[program.to_str().unwrap(), "example"]);
}

#[test]
#[ignore = "needs LONGSTEP_BEHAVIOR_TREES_PYTHON, which tools/peers/behavior_trees/python.sh prints"]
fn modules_of_the_shipped_domains_tick_the_steps_of_their_plans() {
    let folder = tempfile::tempdir().unwrap();
    let python = python();
    let driver = folder.path().join("driver.py");
    std::fs::write(&driver, include_str!("scripted.py")).unwrap();
    let mut modules: BTreeMap<String, PathBuf> = BTreeMap::new();
    for domain in shipped_domains() {
        let path = folder.path().join(format!("{}.py", domain.name.replace('-', "_")));
        std::fs::write(&path, nodes::write(&domain, Language::Python)).unwrap();
        modules.insert(domain.name.clone(), path);
    }
    let mut all: Vec<PathBuf> = modules.values().cloned().collect();
    all.push(hostile::module(folder.path()));
    all.extend(example::module(folder.path()));
    check_types(folder.path(), &all);
    let mut count = Count::default();
    for (domain, plans) in plans_by_domain() {
        let words = [&python, driver.to_str().unwrap(), modules[&domain].to_str().unwrap()];
        tick_all(
            &starter(folder.path(), &format!("start-{domain}"), &words),
            &plans,
            &mut count,
        );
    }
    println!("{count:?}");
    assert_all_kinds(&count);
    example::assert_runs(
        folder.path(),
        &[&python, folder.path().join("robot.py").to_str().unwrap()],
    );
}
