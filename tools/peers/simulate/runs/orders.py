"""Orders: each is the next step of the plan in force, approved, looked at before, possible and allowed."""

from .purpose import step_faults
from .view import truth

# An approved step of which only that is known.
ANY = "any"


def check(judge, order) -> None:
    """Judges an order before it is performed."""
    check_place(judge, order)
    check_approval(judge, order)
    check_looks(judge, order)
    check_step(judge, order)


def check_place(judge, order) -> None:
    """The step belongs to the plan in force, and is the next one."""
    if not 1 <= order.step <= len(judge.plan) or judge.plan[order.step - 1] is not order.action:
        judge.blame("a step that is not in the plan in force", f"{order.step} {order.action.name}{order.action.arguments}")
        return
    if any(own.end == "under way" for own in judge.orders.values()):
        judge.blame("an order while another is under way", str(order.number))
    if order.step > judge.next:
        judge.blame("a step is left out", f"{judge.next} before {order.step}")
    if order.step < judge.next:
        judge.blame("a step is repeated", f"{order.step} after {judge.next - 1}")
    # Steps are known by their distance from the end, since the repeated ones and the rest get new numbers.
    order.left = len(judge.plan) - order.step
    done = [own for own in judge.orders.values() if own.plan == judge.plans and own.left == order.left]
    retries = judge.world.words.retries.get(order.action.name, 2)
    if sum(own.end == "performed" and not own.worked for own in done) > retries:
        judge.blame("a step is repeated more often than its retries", f"{order.action.name} {len(done)} times")
    key = (order.action.name, order.action.arguments)
    if judge.streaks[key] > retries:
        judge.blame("a step that failed more often than its retries", f"{key} {judge.streaks[key]} times")


def check_approval(judge, order) -> None:
    """A person approved what the policy asks for."""
    if not judge.may_run:
        judge.blame("unapproved", f"order {order.number} under `{judge.settings.approval}`")
    # A stricter policy counts from the event on that says so; the log may lack events before it, which are written first.
    if judge.before.approval == "each-step":
        call, state = judge.approved_step or (None, None)
        if call is None or (call != ANY and judge.action(call) is not order.action) or state != judge.belief.state.key():
            judge.blame("unapproved step", f"order {order.number}")


def check_looks(judge, order) -> None:
    """The world was observed when the policy says so."""
    last = judge.orders.get(order.number - 1)
    needed = last is None or judge.settings.watch == "each-step" or last.end != "performed"
    if needed and not judge.looked:
        judge.blame("an order without a look", f"order {order.number} after {last and last.end}")


def check_step(judge, order) -> None:
    """The step can be done and is allowed in the believed world."""
    action, state = order.action, judge.belief.state
    if truth(action.condition, judge.belief.view(judge.certain)) is False:
        judge.blame("precondition", f"order {order.number} {action.name}{action.arguments}")
        return
    for own in judge.purpose.constraints:
        if own.forbids(action):
            judge.blame("forbidden", f"order {order.number} by {own.text}")
    if judge.is_open(action.condition) or any(judge.is_open(when) for when, *_ in [*action.effects, *action.changes]):
        judge.counts["open order"] += 1
        return
    for fault in step_faults(judge.purpose, action, state):
        name = fault.removeprefix("breaks ")
        # A rule has an instance for each binding of its variables, and all have its name.
        if any(own == name and judge.is_open(condition) for own, condition in judge.purpose.kept):
            continue
        if not fault.startswith("forbidden"):
            judge.blame("precondition" if fault == "precondition" else "forbidden", f"order {order.number} {fault}")
