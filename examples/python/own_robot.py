"""A robot of your own: an object with three methods. Every step is compared with what it observes."""

import longstep


class Arm:
    """Knows where things are, and moves them. A real one talks to its controller here."""

    def __init__(self, world: longstep.World) -> None:
        self.simulated = longstep.Sim(world)
        # The predicates that `observe` lists besides the states of entities, such as the place of the hand.
        self.reports = self.simulated.reports

    def begin_plan(self, world: longstep.World) -> None:
        """Begins to count events, such as a wiped table, anew. Robots that report no events need no such method."""
        self.simulated.begin_plan(world)

    def perform(self, action: str, /, *arguments: str) -> None:
        """Returns when the step is done. Raise `longstep.StepFailed` for one that failed; other exceptions stop the run."""
        print(f"  {action} {' '.join(arguments)}")
        self.simulated.perform(action, *arguments)

    def observe(self) -> longstep.Observation:
        """Looks at the world."""
        return self.simulated.observe()

    def stop(self) -> None:
        """Stops at once: also after Ctrl-C, and after an exception."""
        self.simulated.stop()


def ask(question: longstep.RunQuestion) -> bool:
    """Shows a person the plan, or a change of it. This one says yes to everything."""
    print(question["text"], *question["steps"], sep="\n  ")
    return True


world = longstep.World({
    "assets": ["<desk>", "<shelf>"],
    "objects": ["<pen>"],
    "object_states": {"<pen>": "on_something(<desk>)"},
})
plan = longstep.solve(world, "put(pen, shelf)").verified()
run = longstep.run(plan, Arm(world), ask=ask)
print(run, run.world.environment()["object_states"])
assert run.is_done
