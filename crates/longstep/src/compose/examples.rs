//! Few-shot examples of compositions. Their objects occur in no shipped domain.

/// Stored plans, an instruction, and the composition that it asks for.
pub(super) struct CompositionExample {
    /// For each plan: name, summary, and lane ("" if none).
    pub(super) plans: &'static [(&'static str, &'static str, &'static str)],
    /// Sensing calls; for each outcome, the condition and its description.
    pub(super) checks: &'static [(&'static str, &'static [(&'static str, &'static str)])],
    pub(super) wish: &'static str,
    /// A script, or `question: ...`.
    pub(super) answer: &'static str,
}

const RIPENESS: (&str, &[(&str, &str)]) = (
    "look_at(\"pear\")",
    &[
        ("ripe(\"pear\")", "the pear is ripe"),
        ("rotten(\"pear\")", "the pear is rotten"),
    ],
);

const BATTERY: (&str, &[(&str, &str)]) = (
    "test_battery(\"torch\")",
    &[
        ("charged(\"torch\")", "the torch is charged"),
        ("drained(\"torch\")", "the torch is drained"),
    ],
);

const PEAR: &[(&str, &str, &str)] = &[
    ("fetch_pear", "take the pear from the tree", ""),
    ("compost_pear", "drop the pear on the compost", ""),
    ("basket_pear", "lay the pear into the basket", ""),
    ("close_gate", "close the garden gate", ""),
];

const TORCH: &[(&str, &str, &str)] = &[
    ("plan_0", "get the torch out of the toolbox", ""),
    ("plan_1", "plug the torch in", ""),
    ("plan_2", "hang the torch on its hook", ""),
    ("plan_3", "sweep the garage", ""),
];

const ARMS: &[(&str, &str, &str)] = &[
    ("hang_coat", "hang the coat on the peg", "left"),
    ("shelve_hat", "put the hat on the rack", "right"),
    ("stow_boots", "put the boots into the chest", "right"),
];

pub(super) const EXAMPLES: &[CompositionExample] = &[
    CompositionExample {
        plans: PEAR,
        checks: &[RIPENESS],
        wish: "Pick the pear and put it into the basket.",
        answer: "fetch_pear()\nbasket_pear()",
    },
    CompositionExample {
        plans: PEAR,
        checks: &[RIPENESS],
        wish: "Pick the pear. If it is rotten it goes on the compost, otherwise into the basket.",
        answer: "fetch_pear()\nlook_at(\"pear\")\nif rotten(\"pear\"):\n    compost_pear()\nelse:\n    basket_pear()",
    },
    CompositionExample {
        plans: TORCH,
        checks: &[BATTERY],
        wish: "Sweep the garage, but hang up the torch before that. It is in the toolbox.",
        answer: "plan_0()\nplan_2()\nplan_3()",
    },
    CompositionExample {
        plans: TORCH,
        checks: &[BATTERY],
        wish: "Get the torch and see whether it is charged: hang it up if so, else plug it in. Then sweep the garage.",
        answer: "plan_0()\ntest_battery(\"torch\")\nif charged(\"torch\"):\n    plan_2()\nelse:\n    plan_1()\nplan_3()",
    },
    CompositionExample {
        plans: ARMS,
        checks: &[],
        wish: "The coat goes on its peg and the hat on the rack, both at the same time.",
        answer: "with parallel():\n    with lane(\"left\"):\n        hang_coat()\n    with lane(\"right\"):\n        shelve_hat()",
    },
    CompositionExample {
        plans: TORCH,
        checks: &[BATTERY],
        wish: "If the battery of the torch is drained, sweep the garage.",
        answer: "test_battery(\"torch\")\nif drained(\"torch\"):\n    plan_3()",
    },
    CompositionExample {
        plans: PEAR,
        checks: &[RIPENESS],
        wish: "Mow the lawn.",
        answer: "question: I have no plan for mowing the lawn. What should I do instead?",
    },
    CompositionExample {
        plans: PEAR,
        checks: &[RIPENESS],
        wish: "Take the pear down and lay it into the basket, unless it is rotten: throw it on the compost then. Shut the gate in the end.",
        answer: "fetch_pear()\nlook_at(\"pear\")\nif rotten(\"pear\"):\n    compost_pear()\nelse:\n    basket_pear()\nclose_gate()",
    },
    CompositionExample {
        plans: ARMS,
        checks: &[],
        wish: "Let one arm see to the coat while the other puts the hat up and the boots away.",
        answer: "with parallel():\n    with lane(\"left\"):\n        hang_coat()\n    with lane(\"right\"):\n        shelve_hat()\n        stow_boots()",
    },
    CompositionExample {
        plans: ARMS,
        checks: &[],
        wish: "First the boots, then the coat.",
        answer: "stow_boots()\nhang_coat()",
    },
];
