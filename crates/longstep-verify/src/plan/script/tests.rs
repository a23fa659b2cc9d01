use super::super::tree::DEEPEST;
use super::{read, write};

/// Checks that the script parses, and that it is written as `written`.
#[track_caller]
fn check(script: &str, written: &str) {
    let plan = read(script).unwrap_or_else(|error| panic!("{error}\n  hint: {}\n{script}", error.hint));
    assert!(plan.is_sound());
    let again = write(&plan);
    assert_eq!(again, written, "{plan:#?}");
    assert_eq!(read(&again), Ok(plan));
}

#[track_caller]
fn refused(script: &str, message: &str) {
    let error = read(script).unwrap_err();
    assert_eq!(error.to_string(), message, "{script}");
    assert!(!error.hint.is_empty());
}

#[test]
fn scripts_are_read_and_written_in_one_style() {
    for (script, written) in [
        ("", ""),
        ("a()", "a()\n"),
        ("  a ( )  #  take it \n\n  b()\n", "a()  # take it\nb()\n"),
        ("```python\na()\n```\n", "a()\n"),
        (
            "put('<pie_1>', <oven>, left)",
            "put(\"<pie_1>\", \"<oven>\", \"left\")\n",
        ),
        (
            "put(\"<pie>\",  # the pie\n    to='<rack>',\n) # goes in",
            "put(\"<pie>\", to=\"<rack>\")  # the pie goes in\n",
        ),
        ("detach(from='<x>')", "detach(from_=\"<x>\")\n"),
        ("# first\na()\n# last", "# first\na()\n# last\n"),
        ("# objects: [\"<pen>\"]\na()", "# objects: [\"<pen>\"]\na()\n"),
        ("# \"two\\nlines\"\na()  # \"\"\n", "# \"two\\nlines\"\na()\n"),
        ("## \"no text\na()", "# \"\\\"no text\"\na()\n"),
        (
            "if a():\n  b()\nelif not b() and (c() or d('<x>')):\n  pass\nelse:\n\n  c()\nd()",
            "if a():\n    b()\nelif not b() and (c() or d(\"<x>\")):\n    pass\nelse:\n    c()\nd()\n",
        ),
        ("if a(): b() # do\nelse: pass", "if a():\n    b()  # do\n"),
        (
            "if ((a() and b()) and c()):\n\tpass",
            "if (a() and b()) and c():\n    pass\n",
        ),
        ("if not (not a()):\n pass", "if not not a():\n    pass\n"),
        (
            "if (a() # one\n  and b()): # two\n  # only words\n  pass",
            "if (a()  # one\n    and b()):  # two\n    # only words\n    pass\n",
        ),
        (
            "if a():\n  b()\n# otherwise\nelse:\n  c()",
            "if a():\n    b()\nelse:\n    # otherwise\n    c()\n",
        ),
        (
            "if a():\n  b()\n  # then\nelse:\n  c()",
            "if a():\n    b()\n    # then\nelse:\n    c()\n",
        ),
        (
            "if a():\n  b()\n# otherwise\nelif c():\n  d()",
            "if a():\n    b()\nelse:\n    # otherwise\n    if c():\n        d()\n",
        ),
        (
            "while not a():  # look\n  b()\n# after\n",
            "while not a():  # look\n    b()\n# after\n",
        ),
        (
            "for i in range(3):  # thrice\n  a()\n  # end",
            "for _ in range(3):\n    # thrice\n    a()\n    # end\n",
        ),
        (
            "with parallel(): # both\n  # one\n  with lane('left'): # l\n    a() # A\n    sync('x')\n  with lane(right):\n    pass\n  # done\n",
            "# both\nwith parallel():\n    with lane(\"left\"):\n        # one\n        # l\n        a()  # A\n        sync(\"x\")\n    \
             with lane(\"right\"):\n        # done\n        pass\n",
        ),
        ("a(\\\n)", "a()\n"),
    ] {
        check(script, written);
    }
}

#[test]
fn script_errors_name_the_position_of_unsupported_syntax() {
    for (script, message) in [
        ("x = a()", "line 1, column 3: this is an assignment, which no plan has"),
        (
            "a()\nimport os",
            "line 2, column 1: this is an import, which no plan has",
        ),
        (
            "def f():\n  a()",
            "line 1, column 1: this is a function, which no plan has",
        ),
        (
            "if a() == True:\n  b()",
            "line 1, column 8: this is a comparison, which no plan has",
        ),
        ("if x in y():\n  b()", "line 1, column 4: `x` is no call"),
        (
            "if a() is b():\n  b()",
            "line 1, column 8: this is a comparison, which no plan has",
        ),
        ("while True:\n  a()", "line 1, column 7: this is decided already"),
        (
            "while a():\n  break",
            "line 2, column 3: this is a jump, which no plan has",
        ),
        (
            "return",
            "line 1, column 1: this is the end of a function, which no plan has",
        ),
        (
            "a(f'{x}')",
            "line 1, column 3: this is a text with the prefix `f`, which no plan has",
        ),
        ("a(b())", "line 1, column 4: this is a call in a call"),
        (
            "a([1])",
            "line 1, column 3: this is a list or an index, which no plan has",
        ),
        (
            "a({})",
            "line 1, column 3: this is a set or a dictionary, which no plan has",
        ),
        (
            "a(lambda: 1)",
            "line 1, column 3: this is a function, which no plan has",
        ),
        ("a('x' 'y')", "line 1, column 7: this is a second text"),
        (
            "a('x', to='y', 'z')",
            "line 1, column 16: this stands behind a parameter that is given by name",
        ),
        (
            "a(to='x', to='y')",
            "line 1, column 11: this parameter cannot be given here",
        ),
        ("a('x, y')", "line 1, column 3: this names nothing"),
        ("robot.a()", "line 1, column 6: this is an attribute, which no plan has"),
        ("a", "line 1, column 1: `a` is no call"),
        ("a() b()", "line 1, column 5: the line should end here"),
        (
            "a(); b()",
            "line 1, column 4: this is a second statement on a line, which no plan has",
        ),
        (
            "try:\n  a()",
            "line 1, column 1: this is error handling, which no plan has",
        ),
        ("print('x')", "line 1, column 1: this is output, which no plan has"),
        ("'''doc'''", "line 1, column 1: this is a text in three quotes"),
        ("a('x", "line 1, column 3: this text does not end on its line"),
        ("a(\nb", "line 1, column 2: this parenthesis is never closed"),
        ("a())", "line 1, column 4: this parenthesis closes nothing"),
        ("a('\\q')", "line 1, column 4: this escape means nothing in a plan"),
        ("if a():\nb()", "line 2, column 1: a block is missing before this"),
        ("if a()\n  b()", "line 1, column 7: `:` is missing before this"),
        ("a()\n  b()", "line 2, column 3: nothing opens a block here"),
        (
            "if a():\n    b()\n  c()",
            "line 3, column 3: this line is indented like none before it",
        ),
        (
            "if a():\n    b()\n\tc()",
            "line 3, column 1: blanks and tabs are mixed here",
        ),
        ("else:\n  a()", "line 1, column 1: no `if` stands before this"),
        (
            "a() if b() else c()",
            "line 1, column 5: this is a conditional expression, which no plan has",
        ),
        (
            "for x in things:\n  a()",
            "line 1, column 10: no plan has a loop like this",
        ),
        (
            "for x in range(n):\n  a()",
            "line 1, column 16: a number is missing here",
        ),
        (
            "for x in range(1, 3):\n  a()",
            "line 1, column 17: no plan has a loop like this",
        ),
        (
            "for x in range(99999999999):\n  a()",
            "line 1, column 16: this is no number of times",
        ),
        (
            "with open('x'):\n  a()",
            "line 1, column 6: no plan has a `with` like this",
        ),
        ("with parallel():\n  a()", "line 2, column 3: a lane is missing here"),
        (
            "with parallel():\n  with lane('l'):\n    if a():\n      b()",
            "line 3, column 5: nothing branches or repeats in a lane",
        ),
        (
            "with parallel():\n  with lane('l'):\n    a()\n  with lane('l'):\n    a()",
            "line 4, column 3: `l` has a lane already",
        ),
        (
            "with lane('l'):\n  a()",
            "line 1, column 1: this is a lane outside of `with parallel():`",
        ),
        ("sync('x')", "line 1, column 1: only lanes wait for each other"),
        (
            "# objects: pen\na()",
            "line 1, column 1: the list of objects cannot be read",
        ),
    ] {
        refused(script, message);
    }
}

#[test]
fn script_reader_limits_nesting_depth() {
    let nested = |depth: usize| {
        let branches: String = (0..depth).map(|at| format!("{}if a():\n", " ".repeat(at))).collect();
        format!("{branches}{}b()\n", " ".repeat(depth))
    };
    assert!(read(&nested(DEEPEST)).is_ok());
    let error = read(&nested(DEEPEST + 1)).unwrap_err();
    assert_eq!(
        (error.position.line, error.position.column),
        (DEEPEST as u32 + 1, DEEPEST as u32 + 1)
    );
    let chain = format!("if a():\n  b()\n{}", "elif a():\n  b()\n".repeat(10_000));
    assert!(read(&chain).is_err());
    assert!(read(&format!("if {}a():\n  b()", "not ".repeat(100_000))).is_err());
    assert!(read(&format!("if {}a()", "(".repeat(100_000))).is_err());
}

mod random {
    use proptest::prelude::*;

    use super::super::{read, write};
    use crate::plan::tree::Lane;
    use crate::plan::{
        self, LaneItem, Node, PlanFile, StepId, TaskCohesion, Test, Written, WrittenNode, WrittenStep, read_tree,
        write_tree,
    };
    use longstep_model::call::Call;
    use longstep_model::json::Path;

    const TEXTS: [&str; 15] = [
        "",
        "take it",
        " blank before",
        "two\nlines",
        "# sign",
        "\"quoted\"",
        "objects: [\"<a>\"]",
        "Tür öffnen; <door>: open()",
        "tab\there\u{7}",
        "if a(): b()",
        "back\\slash 'and \"quotes",
        "ends with \u{a0}",
        "\u{1b}[2Jju\u{202e}ice\u{85}\r",
        "tag\u{e0041} line\u{2028}",
        "\u{200b}hidden\u{9b}31m",
    ];
    const NAMES: [&str; 5] = ["a", "put_in", "PutIn2", "wait-here", "ö"];
    const ARGUMENTS: [&str; 5] = ["<pie_320>", "left", "3", "two words", "\"odd\" \\ <"];
    const PARAMETERS: [&str; 5] = ["to", "from", "in_", "from__", "by-hand"];

    /// Pseudorandom plan generator with a seed.
    struct Draw {
        seed: u64,
        steps: Vec<WrittenStep>,
    }

    impl Draw {
        fn below(&mut self, limit: usize) -> usize {
            self.seed = self
                .seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.seed >> 33) as usize % limit
        }

        fn one(&mut self, of: &[&str]) -> String {
            of[self.below(of.len())].to_owned()
        }

        fn call(&mut self) -> WrittenStep {
            let arguments = (0..self.below(3)).map(|_| self.one(&ARGUMENTS)).collect();
            let first = self.below(2 * PARAMETERS.len());
            let named = PARAMETERS.iter().skip(first).take(2);
            WrittenStep {
                call: Call {
                    name: self.one(&NAMES),
                    arguments,
                },
                implicit: named.map(|name| ((*name).to_owned(), self.one(&TEXTS))).collect(),
                explanation: self.one(&TEXTS),
            }
        }

        fn step(&mut self) -> StepId {
            let step = self.call();
            self.steps.push(step);
            StepId::new(self.steps.len() - 1)
        }

        fn test(&mut self, depth: usize) -> Test<WrittenStep> {
            let parts = |draw: &mut Self| (0..2 + draw.below(2)).map(|_| draw.test(depth + 1)).collect();
            match self.below(if depth < 3 { 6 } else { 2 }) {
                0..=2 => Test::Holds(self.call()),
                3 => Test::Not(Box::new(self.test(depth + 1))),
                4 => Test::All(parts(self)),
                _ => Test::Any(parts(self)),
            }
        }

        fn nodes(&mut self, depth: usize) -> Vec<WrittenNode> {
            (0..self.below(4)).map(|_| self.node(depth)).collect()
        }

        fn node(&mut self, depth: usize) -> WrittenNode {
            match self.below(if depth < 4 { 9 } else { 4 }) {
                0..=2 => Node::Step(self.step()),
                3 => Node::Remark(self.one(&TEXTS)),
                4 | 5 => Node::If {
                    condition: self.test(0),
                    then: self.nodes(depth + 1),
                    otherwise: self.nodes(depth + 1),
                },
                6 => Node::While {
                    condition: self.test(0),
                    body: self.nodes(depth + 1),
                },
                7 => Node::Repeat {
                    times: self.below(9) as u32,
                    body: self.nodes(depth + 1),
                },
                _ => Node::Parallel {
                    lanes: (0..1 + self.below(2)).map(|number| self.lane(number)).collect(),
                },
            }
        }

        fn lane(&mut self, number: usize) -> Lane<String> {
            let item = |draw: &mut Self| match draw.below(4) {
                0 => LaneItem::Sync(draw.one(&TEXTS)),
                1 => LaneItem::Remark(draw.one(&TEXTS)),
                _ => LaneItem::Step(draw.step()),
            };
            Lane {
                actor: format!("{number}{}", self.one(&TEXTS)),
                items: (0..self.below(4)).map(|_| item(self)).collect(),
            }
        }
    }

    fn draw(seed: u64) -> Written {
        let mut draw = Draw {
            seed,
            steps: Vec::new(),
        };
        let body = draw.nodes(0);
        let objects = (0..draw.below(3)).map(|_| draw.one(&TEXTS)).collect();
        Written {
            steps: draw.steps,
            body,
            objects,
        }
    }

    proptest! {
        #[test]
        fn script_and_task_tree_keep_the_whole_plan(seed in any::<u64>()) {
            let written = draw(seed);
            prop_assert!(written.is_sound());
            let script = write(&written);
            prop_assert!(!script.contains(|c| c != '\n' && longstep_model::visible::is_hidden(c)), "{:?}", script);
            prop_assert_eq!(&read(&script).unwrap(), &written, "{}", script);
            let text = write_tree(&written).to_string();
            let tree = read_tree(&serde_json::from_str(&text).unwrap(), written.objects.clone(), &Path::default());
            prop_assert_eq!(tree.as_ref(), Ok(&written), "{}", text);
            prop_assert_eq!(write(&tree.unwrap()), script);
        }

        #[test]
        fn a_plan_file_keeps_a_tree(seed in any::<u64>()) {
            let file = PlanFile::from(TaskCohesion::from_written(draw(seed)));
            let text = serde_json::to_string(&file).unwrap();
            prop_assert_eq!(&serde_json::from_str::<PlanFile>(&text).unwrap(), &file);
            let draft = plan::read(&text).unwrap();
            prop_assert_eq!(draft.file, file);
        }

        #[test]
        fn no_text_panics(parts in prop::collection::vec(prop::sample::select(vec![
            "if ", "elif ", "else:", "while ", "for _ in range(2):", "with parallel():", "with lane('l'):", "sync('a')",
            "pass", "a()", "b('<x>')", "not ", " and ", " or ", "(", ")", ":", "\n", "\n  ", "\n    ", "\n\t", "# c",
            "'", "\"", "\\", "\\u12", "=", ",", "<y>", "<", "é", "\u{feff}", "\u{a0}", "\r\n", "```", "{", "3", "-", "objects: [",
        ]), 0..60)) {
            let text: String = parts.concat();
            if let Ok(written) = read(&text) {
                prop_assert_eq!(read(&write(&written)), Ok(written));
            }
            let _ = plan::read(&text);
        }

        #[test]
        fn any_text_is_read_or_refused(text in "\\PC*") {
            let _ = read(&text);
        }
    }
}
