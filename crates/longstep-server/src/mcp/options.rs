//! The options of the server.

use std::time::Duration;

use crate::approval::APPROVAL_LIFETIME;
use crate::hub::NewSession;

/// The time in which a plan that was shown may be carried out, unless the options say another.
const PLAN_LIFETIME: Duration = Duration::from_secs(30 * 60);

/// The time in which a person answers a form, unless the options say another.
const FORM_LIFETIME: Duration = Duration::from_secs(5 * 60);

/// The options of a Model Context Protocol server.
///
/// ```
/// use longstep_server::NewSession;
/// use longstep_server::mcp::McpOptions;
///
/// let options = McpOptions::new(NewSession::of_scene("pantry"))
///     .with_robot("sim".to_owned())
///     .with_page("http://127.0.0.1:8734".to_owned());
/// assert_eq!(options.robot.as_deref(), Some("sim"));
/// ```
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct McpOptions {
    /// The world in which sessions begin.
    pub start: NewSession,
    /// The robot of `execute_plan` without one; none if the only robot of the hub is meant.
    pub robot: Option<String>,
    /// The address of the page on which a person can approve; none without a page. `{session}` in it becomes the id of
    /// the session.
    pub page: Option<String>,
    /// The time in which a plan that was shown may be carried out; 30 minutes.
    pub plan_lifetime: Duration,
    /// The time in which a person answers a form; 5 minutes.
    pub form_lifetime: Duration,
    /// The time in which an approval starts its run; 10 minutes.
    pub approval_lifetime: Duration,
    /// The host names under which HTTP clients reach the server; `localhost`, `127.0.0.1` and `::1`.
    pub hosts: Vec<String>,
    /// The origins of web pages that may call the server over HTTP; none.
    pub origins: Vec<String>,
}

impl McpOptions {
    /// Creates the options of a server whose sessions begin in a world.
    pub fn new(start: NewSession) -> Self {
        Self {
            start,
            robot: None,
            page: None,
            plan_lifetime: PLAN_LIFETIME,
            form_lifetime: FORM_LIFETIME,
            approval_lifetime: APPROVAL_LIFETIME,
            hosts: ["localhost", "127.0.0.1", "::1"].map(str::to_owned).to_vec(),
            origins: Vec::new(),
        }
    }

    /// Sets the robot of `execute_plan` without one.
    #[must_use]
    pub fn with_robot(self, robot: impl Into<Option<String>>) -> Self {
        Self {
            robot: robot.into(),
            ..self
        }
    }

    /// Sets the address of the page on which a person can approve.
    #[must_use]
    pub fn with_page(self, page: impl Into<Option<String>>) -> Self {
        Self {
            page: page.into(),
            ..self
        }
    }

    /// Sets the time in which a plan that was shown may be carried out.
    #[must_use]
    pub fn with_plan_lifetime(self, plan_lifetime: Duration) -> Self {
        Self { plan_lifetime, ..self }
    }

    /// Sets the time in which a person answers a form.
    #[must_use]
    pub fn with_form_lifetime(self, form_lifetime: Duration) -> Self {
        Self { form_lifetime, ..self }
    }

    /// Sets the time in which an approval starts its run.
    #[must_use]
    pub fn with_approval_lifetime(self, approval_lifetime: Duration) -> Self {
        Self {
            approval_lifetime,
            ..self
        }
    }

    /// Sets the host names under which HTTP clients reach the server.
    #[must_use]
    pub fn with_hosts(self, hosts: Vec<String>) -> Self {
        Self { hosts, ..self }
    }

    /// Sets the origins of web pages that may call the server over HTTP.
    #[must_use]
    pub fn with_origins(self, origins: Vec<String>) -> Self {
        Self { origins, ..self }
    }
}
