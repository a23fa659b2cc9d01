"""The judge of a run: each event is compared with what docs/reference/execution.md allows after the events before it."""

from collections import Counter
from dataclasses import dataclass

from ..words import split_call
from ..world import holds
from . import ending, orders
from .belief import OBSERVED, SURMISED, Belief
from .make import Entries
from .purpose import Progress, Purpose, StateView, Tracker, events_of, step_faults
from .view import keys_of
from .world import NumberAction, NumberWorld

STRICTNESS = {"approval": ["never", "changes", "each-step"], "trust": ["promised", "observed"]}


@dataclass
class Order:
    """An order of the log."""

    number: int
    step: int
    action: NumberAction
    plan: int
    end: str = "under way"
    before: object = None
    left: int = 0
    # True if all its effects are there after a difference because of which it is repeated.
    worked: bool = False


@dataclass
class Settings:
    """The settings of a run."""

    approval: str = "changes"
    watch: str = "each-step"
    trust: str = "observed"
    changes: int = 8

    def as_json(self) -> dict:
        """The settings as a command has them."""
        return {"approval": self.approval, "watch": self.watch, "trust": self.trust, "changes": self.changes}


class Judge:
    """Judges the events of one run in their order."""

    def __init__(self, world: NumberWorld, entries: Entries, purpose: Purpose, plan: list[NumberAction], settings: Settings, reports: set):
        self.world, self.entries, self.purpose, self.settings = world, entries, purpose, settings
        # The settings that the log has so far.
        self.before = settings
        self.belief = Belief(world, entries, reports)
        self.sentences = entries.sentences
        self.plan, self.plans, self.next = plan, 0, 1
        self.orders: dict[int, Order] = {}
        # Failures of each call in the whole run, and since it was done, the plan was changed or the run was taken up.
        self.failures: Counter = Counter()
        self.streaks: Counter = Counter()
        # How often a call was done and a look showed something else than its effects.
        self.idle: Counter = Counter()
        self.unseen_orders: list[Order] = []
        self.verdicts: list[str] = []
        self.counts: Counter = Counter()
        # What a person decided: hashes that were approved, and the last proposal.
        self.proposed: dict | None = None
        self.may_run = settings.approval == "never"
        self.approved_step: tuple | None = None
        # What happened since the last order.
        self.looked = False
        self.ended: str | None = None
        self.confirmed: dict[tuple, object] = {}
        self.lenient = Tracker(purpose, strict=False)
        self.progress: Progress = self.lenient.start(self.belief.view(self.evident))
        self.strict = Tracker(purpose, strict=True)
        # A strict reading begins with the first look.
        self.strict_progress: Progress | None = None
        self.strict_events: frozenset = frozenset()
        self.errors = self.signals = self.refusals = 0
        self.last_look: dict | None = None
        self.answer: bool | None = None
        self.confirming: tuple | None = None
        self.denied = False
        self.refusal = ""
        # True for a run through the program, of which the judge sees the log alone.
        self.hears = False

    def blame(self, kind: str, detail: str = "") -> None:
        """Notes a violation."""
        self.verdicts.append(f"{kind}: {detail}" if detail else kind)

    # --- sources --------------------------------------------------------------------------------------------

    def evident(self, key: tuple) -> bool:
        """True for what counts as evidence: observed, or nothing can show it; with trust, any promise."""
        return self.was_seen(key) or (self.settings.trust == "promised" and self.belief.visible(key))

    def was_seen(self, key: tuple) -> bool:
        """As `evident`, but no promise counts."""
        if not self.belief.visible(key):
            return self.belief.source_of(key)[0] != SURMISED
        return key in self.confirmed or not self.changes(key) or self.belief.source_of(key)[0] == OBSERVED

    def certain(self, key: tuple) -> bool:
        """True for all beliefs but those that the pages leave open."""
        return self.belief.source_of(key)[0] != SURMISED

    def changes(self, key: tuple) -> bool:
        """True for what some action of the domain can change."""
        return (key[1][0] if key[0] == "#" else key[0]) in self.world.words.changing

    def is_open(self, condition) -> bool:
        """True if a condition reads what the pages leave open."""
        return any(not self.certain(key) for key in keys_of(condition))

    # --- decisions of a person ------------------------------------------------------------------------------

    def propose(self, proposal: dict, answer: bool | None) -> None:
        """A person decides about a proposal."""
        self.proposed = {**proposal, "answer": answer}
        if self.settings.approval == "never":
            self.blame("asked although nobody decides", proposal["subject"])
        if proposal["subject"] == "step" and self.settings.approval != "each-step":
            self.blame("asked about a step", proposal["call"])
        self.refusals += answer is not True

    def approved(self, event: dict) -> None:
        """An approval in the log."""
        if self.hears:
            # The program asked somebody who always says yes; the log does not say what about.
            if self.may_run:
                self.approved_step = (orders.ANY, self.belief.state.key())
            self.may_run = True
            return
        if self.proposed is None or event["proposal"] != self.proposed["id"] or self.proposed["answer"] is not True:
            self.blame("approval that no person gave", event["proposal"])
            return
        if self.proposed["subject"] == "step":
            # The approval is one of this step in this world.
            self.approved_step = (self.proposed["call"], self.belief.state.key())
        else:
            self.may_run = True

    def resumes(self, settings: Settings) -> None:
        """The run is taken up again with these settings; the stricter ones count."""
        # What a run was resumed with counts from the event on that says so.
        own = self.before
        approval, trust = (
            max(getattr(own, key), getattr(settings, key), key=STRICTNESS[key].index) for key in ("approval", "trust")
        )
        self.settings = Settings(approval, own.watch, trust, own.changes)

    def started(self, action: NumberAction, stopped: bool) -> None:
        """The robot gets an order, which has to be in the log already."""
        last = self.orders.get(len(self.orders))
        if last is None or last.action is not action or last.end != "under way":
            self.blame("an order that the log does not have", f"{action.name}{action.arguments}")
        if stopped:
            self.blame("an order after a stop", f"{action.name}{action.arguments}")

    # --- events ---------------------------------------------------------------------------------------------

    def event(self, event: dict) -> None:
        """One event of the log."""
        name = event["event"]
        self.counts[name] += 1
        if self.ended is not None and name not in ("interrupted",):
            self.blame("event after the end", name)
        getattr(self, "on_" + name, self.on_other)(event)

    def on_other(self, event: dict) -> None:
        """An event of an unknown kind."""
        self.blame("unknown event", event["event"])

    def on_began(self, event: dict) -> None:
        """The beginning: the log has the settings."""
        for key, own in self.settings.as_json().items():
            if event.get(key, own) != own:
                self.blame("another setting in the log", f"{key} {event[key]}")

    def on_approved(self, event: dict) -> None:
        """An approval."""
        self.settle_unknown()
        self.approved(event)

    def on_refused(self, _: dict) -> None:
        """A refusal."""
        if self.proposed is None or self.proposed["answer"] is not False:
            self.blame("refusal that no person gave")
        self.counts["said no"] += 1

    def on_ordered(self, event: dict) -> None:
        """An order."""
        self.settle_unknown()
        action = self.action(event["call"])
        order = Order(event["order"], event["step"], action, self.plans, before=self.belief.state)
        if order.number != len(self.orders) + 1:
            self.blame("order number", str(order.number))
        orders.check(self, order)
        self.orders[order.number] = order
        self.next = order.step
        self.looked, self.approved_step = False, None

    def action(self, call: str) -> NumberAction:
        """The ground action of a call with all its arguments."""
        name, arguments = split_call(call)
        return self.world.action(name, tuple(own.strip("<>") for own in arguments))

    def on_performed(self, event: dict) -> None:
        """The end of a step."""
        order = self.ending_order(event)
        if order is None:
            return
        order.end = "performed"
        self.streaks[(order.action.name, order.action.arguments)] = 0
        self.next = order.step + 1
        self.unseen_orders.append(order)
        events = self.belief.performed(order.action, order.number)
        self.forget(order)
        self.advance(events)

    def on_failed(self, event: dict) -> None:
        """A step that failed."""
        order = self.ending_order(event)
        if order is None:
            return
        order.end = "failed"
        key = (order.action.name, order.action.arguments)
        self.failures[key] += 1
        self.streaks[key] += 1
        self.belief.failed(order.action, order.number)
        self.forget(order)

    def forget(self, order: Order) -> None:
        """A person's word about what an order could have changed does not count any more."""
        for key in order.action.touches():
            self.confirmed.pop(key, None)

    def ending_order(self, event: dict) -> Order | None:
        """The order that an event ends."""
        order = self.orders.get(event["order"])
        if order is None or order.end != "under way":
            self.blame("the end of an order that is not under way", str(event["order"]))
            return None
        return order

    def on_observed(self, event: dict) -> None:
        """An observation."""
        if self.last_look is not None and event["statements"] != self.last_look:
            self.blame("another observation in the log", str(event["statements"]))
        different = self.belief.observed(event["statements"])
        for order in self.unseen_orders:
            if different & order.action.touches():
                self.idle[(order.action.name, order.action.arguments)] += 1
        self.unseen_orders = []
        self.looked = True
        self.advance(frozenset())

    def advance(self, events: frozenset) -> None:
        """Follows the stages."""
        if self.strict_progress is not None:
            self.strict_events |= events
            if self.looked:
                # A stage is achieved in a state that was observed.
                self.follow_strictly(self.was_seen)
        elif self.looked:
            self.strict_progress = self.strict.start(self.belief.view(self.was_seen))
        self.progress = self.lenient.on(self.progress, self.belief.view(self.may_be_evident), events)

    def follow_strictly(self, counts) -> None:
        """Follows the stages as far as the facts count."""
        self.strict_progress = self.strict.on(self.strict_progress, self.belief.view(counts), self.strict_events)
        self.strict_events = frozenset()

    def may_be_evident(self, key: tuple) -> bool:
        """As `evident`, and what the pages leave open counts too."""
        return self.evident(key) or not self.belief.visible(key)

    def on_assessed(self, event: dict) -> None:
        """A difference. Steps that are repeated or skipped make another plan of the rest, with numbers of its own."""
        self.settle_unknown()
        if event["effect"] == "harmless":
            self.check_rest("harmless", self.plan[self.next - 1 :])
        if event["effect"] == "undone":
            begun = max(0, self.next - 1 - len(event.get("steps", [])))
            self.repeats(begun)
            self.plan, self.next = self.plan[begun:], 1
        if event["effect"] == "helpful":
            self.plan, self.next = self.plan[self.next - 1 + len(event.get("steps", [])) :], 1
            self.check_rest("helpful", self.plan)

    def repeats(self, begun: int) -> None:
        """Steps are repeated from a place of the plan on: those of them failed of which an effect is missing, or else all."""
        ends = [own for own in self.orders.values() if own.plan == self.plans and own.end == "performed"]
        last = {own.left: own for own in ends}
        places = range(begun, self.next - 1)
        later: set = set()
        for place in reversed(places):
            order = last.get(len(self.plan) - place - 1)
            if order is not None:
                after = self.world.apply(order.action, order.before)
                changed = {key for key in order.action.touches() if Belief.differs(key, order.before, after)} - later
                order.worked = not any(Belief.differs(key, self.belief.state, after) for key in changed)
                later |= changed
        orders = [last.get(len(self.plan) - place - 1) for place in places]
        is_known = any(own is not None and not own.worked for own in orders)
        for place, order in zip(places, orders):
            if order is None or not order.worked or not is_known:
                self.idle[(self.plan[place].name, self.plan[place].arguments)] += 1

    def check_rest(self, claim: str, rest: list[NumberAction]) -> None:
        """The rest of a plan is valid from the believed world and reaches the goal, as was said."""
        faults = rest_faults(self.purpose, rest, self.belief.state, self.progress)
        if faults and not self.reads_open(rest):
            self.blame(f"{claim}, but the rest is not valid", faults[0])

    def reads_open(self, steps: list[NumberAction]) -> bool:
        """True if the steps or the purpose read what the pages leave open."""
        conditions = [part.condition for _, part in self.purpose.parts()] + self.purpose.at_end()
        conditions += [condition for _, condition in self.purpose.kept]
        for action in steps:
            conditions += [action.condition, *(when for when, *_ in [*action.effects, *action.changes])]
        return any(self.is_open(condition) for condition in conditions)

    def on_changed(self, event: dict) -> None:
        """A change of the rest of the plan."""
        self.settle_unknown()
        rest = self.plan[self.next - 1 :]
        new = [self.action_of_entry(entry) for entry in event["plan"]]
        if self.settings.approval != "never" and Counter(map(id, new)) - Counter(map(id, rest)):
            self.may_run = False
        self.plan, self.next = new, 1
        self.plans += 1
        self.streaks.clear()
        self.check_rest("changed", new)
        if self.plans > self.settings.changes:
            self.blame("too many changes", str(self.plans))

    def action_of_entry(self, entry: dict) -> NumberAction:
        """The ground action of a step in a plan that hides nothing."""
        name, arguments = split_call(entry["call"])
        call = self.world.words.calls[name]
        binding = dict(zip(call.shown, arguments)) | {"?" + name: own for name, own in entry.get("implicit", {}).items()}
        own = tuple(binding[name].strip("<>") for name, _ in call.action.parameters)
        return self.world.action(call.action.name, own)

    def on_interrupted(self, event: dict) -> None:
        """The run was taken up again."""
        ends = {own.number: own.end for own in self.orders.values()}
        under_way = [number for number, end in ends.items() if end == "under way"]
        # A look may have settled an order that was unknown before, which no event says.
        if not set(under_way) <= set(event["under_way"]) <= {number for number, end in ends.items() if end in ("under way", "unknown")}:
            self.blame("other orders under way", f"{event['under_way']} instead of {under_way}")
        for number in event["under_way"]:
            order = self.orders[number]
            order.end = "unknown"
            self.belief.failed(order.action, number)
            self.forget(order)
        self.ended, self.looked, self.denied = None, False, False
        self.streaks.clear()
        for key, before in (("approval", self.before.approval), ("trust", self.before.trust)):
            now = getattr(self.settings, key)
            if event.get(key) != (None if now == before else now):
                self.blame("another setting in the log", f"{key} {event.get(key)} instead of {now}")
        if self.before.approval == "never" and self.settings.approval != "never":
            self.may_run = False
        self.before = self.settings

    def on_found(self, event: dict) -> None:
        """An unknown order was done, as the world shows."""
        order = self.orders.get(event["order"])
        if order is None or order.end != "unknown":
            self.blame("found an order that is not unknown", str(event["order"]))
            return
        after = self.world.apply(order.action, order.before)
        for key in order.action.touches():
            if self.belief.visible(key) and Belief.differs(key, order.before, after):
                if key not in self.belief.shown or Belief.differs(key, after, self.belief.state):
                    self.blame("found, but not all effects are seen", str(key))
        self.settle(order, True)

    def on_judged(self, event: dict) -> None:
        """A person said whether an unknown order was done."""
        order = self.orders.get(event["order"])
        if order is None or order.end != "unknown":
            self.blame("a word about an order that is not unknown", str(event["order"]))
            return
        if self.answer is not event["done"]:
            self.blame("another word than the person's", str(event["done"]))
        self.settle(order, event["done"])

    def settle_unknown(self) -> None:
        """An unknown order that a look has not shown was not done, or is a difference like any other."""
        for order in self.orders.values():
            if order.end == "unknown":
                order.end = "not done"

    def settle(self, order: Order, done: bool) -> None:
        """An unknown order was done, or not."""
        order.end = "performed" if done else "not done"
        if not done:
            return
        self.next = order.step + 1
        belief, after = self.belief, self.world.apply(order.action, order.before)
        for key in order.action.touches():
            if key not in belief.shown and Belief.differs(key, order.before, after):
                belief.put(key, after)
        self.advance(events_of(self.world, order.action, order.before))

    def on_confirmed(self, event: dict) -> None:
        """A person said whether something is so."""
        read = self.sentences.read(event["what"])
        if read is None:
            self.blame("a sentence without a meaning", event["what"])
            return
        key, value = read
        if not self.hears and self.confirming != (event["what"], event["holds"]):
            self.blame("another word than the person's", f"{event['what']} {event['holds']}")
        if self.settings.trust == "promised" or self.settings.approval == "never":
            self.blame("asked about a promise", f"trust {self.settings.trust}, approval {self.settings.approval}")
        if self.belief.value(key) != value or not self.belief.visible(key) or key in self.belief.shown:
            self.blame("asked about something else than an open promise", event["what"])
        if event["holds"]:
            self.confirmed[key] = value
            self.advance(frozenset())
        else:
            self.denied = True

    def on_trusted(self, event: dict) -> None:
        """Progress rests on promises."""
        if self.settings.trust != "promised":
            self.blame("a promise is trusted", str(event["unseen"]))
        ending.check_listed(self, event["unseen"])
        if self.strict_progress is not None:
            self.follow_strictly(self.evident)

    def on_stopped(self, event: dict) -> None:
        """The end of a run before its goal."""
        self.ended = "stopped"
        ending.check_stop(self, event)

    def on_done(self, event: dict) -> None:
        """The end of a run that reached its goal."""
        self.ended = "done"
        ending.check_done(self, event)


def rest_faults(purpose: Purpose, steps: list[NumberAction], state, progress: Progress) -> list[str]:
    """The faults of the rest of a plan, in a lenient reading, after the progress that was made."""
    tracker = Tracker(purpose, strict=False)
    world = purpose.world
    progress = tracker.on(progress, StateView(state))
    for number, action in enumerate(steps, 1):
        faults = step_faults(purpose, action, state)
        if faults:
            return [f"step {number}: {fault}" for fault in faults]
        events = events_of(world, action, state)
        state = world.apply(action, state)
        progress = tracker.on(progress, StateView(state), events)
    faults = [] if tracker.is_complete(progress) else [f"stage {progress.stage + 1} is not complete"]
    faults += [f"not reached: {part.text}" for part in purpose.missing(state)]
    return faults + ["a rule for the end" for own in purpose.at_end() if not holds(own, state)]


