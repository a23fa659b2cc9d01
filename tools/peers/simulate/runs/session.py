"""One run with the judge's robot and person at one end of a pipe and the program at the other."""

import json
from random import Random

from . import ending
from .judge import Judge, Settings
from .purpose import plan_faults
from .robot import Died, Robot, action_of
from .scenario import Scenario


class Session:
    """Carries out one scenario."""

    def __init__(self, scenario: Scenario, link, folder: str):
        self.scenario, self.link, self.folder = scenario, link, folder
        self.random = Random(scenario.seed * 31 + len(scenario.steps))
        reports = set(scenario.reports)
        self.judge = Judge(scenario.world, scenario.entries, scenario.purpose, scenario.steps, scenario.settings, reports)
        self.robot = Robot(scenario.world, scenario.entries, scenario.faults, self.random, reports)
        self.log: list[str] = []
        self.torn = ""
        self.given: set[str] = set()
        self.under_way: tuple | None = None
        self.ticks = 0
        self.crashed = 0
        self.stopped = False
        self.proposals: list[str] = []
        self.messages = 0

    # --- the whole run --------------------------------------------------------------------------------------

    def run(self) -> Judge:
        """Runs to the end, through crashes; returns the judge."""
        end = self.until_end(self.scenario.command())
        if "refused" in end:
            self.check_refusal(end["refused"])
            return self.judge
        self.check_begin()
        for _ in range(4):
            if "crashed" in end or self.is_resumable(end):
                if not self.log or self.judge.ended == "done":
                    return self.judge
                was_ended = self.judge.ended is not None
                end = self.resume()
                if "refused" in end and was_ended:
                    return self.judge
                if "refused" in end:
                    self.judge.blame("a run that cannot be resumed", end["refused"]["why"])
                    return self.judge
            else:
                break
        if "ended" in end:
            ending.check_end(self.judge, end["ended"], self.given)
            ending.compare_with_world(self.judge, self.robot)
        elif "panicked" in end:
            self.judge.blame("panic", end["panicked"])
        return self.judge

    def is_resumable(self, end: dict) -> bool:
        """True for a stop by a signal or a failure of the robot that is taken up again, which some are not."""
        if "ended" not in end or self.scenario.crashes == 0:
            return False
        if end["ended"]["stop"] not in ("requested", "robot", "unseen"):
            return False
        ending.check_end(self.judge, end["ended"], self.given)
        return self.random.random() < 0.7

    def check_refusal(self, refused: dict) -> None:
        """A plan that every reading accepts is not refused."""
        self.judge.counts["refused"] += 1
        faults = plan_faults(self.scenario.purpose, self.scenario.steps, self.scenario.world.initial, strict=True)
        if not faults and refused["code"] == 10:
            self.judge.blame("a valid plan is refused", refused["why"])
        elif refused["code"] != 10:
            self.judge.counts[f"refused with {refused['code']}"] += 1
            self.judge.refusal = refused["why"]

    def check_begin(self) -> None:
        """A plan that no reading accepts does not begin."""
        faults = plan_faults(self.scenario.purpose, self.scenario.steps, self.scenario.world.initial, strict=False)
        if faults:
            self.judge.blame("a wrong plan begins", faults[0])

    def resume(self) -> dict:
        """Takes the run up again from the log, mostly with the same settings and a robot that is another process."""
        settings = self.scenario.settings
        self.crashed += 1
        self.given, self.stopped = set(), False
        self.robot.arrive()
        if self.random.random() < 0.3:
            self.robot.meddle("moved")
        approval = self.random.choice([settings.approval, settings.approval, "never", "changes", "each-step"])
        trust = self.random.choice([settings.trust, settings.trust, "observed", "promised"])
        self.judge.resumes(Settings(approval, settings.watch, trust, settings.changes))
        log = "".join(line + "\n" for line in self.log) + self.torn
        self.torn = ""
        return self.until_end(
            {
                "resume": {
                    "domain": self.scenario.domain,
                    "log": log,
                    "folder": self.folder,
                    "approval": approval,
                    "trust": trust,
                    "robot": self.scenario.robot(),
                    "direct": self.scenario.direct,
                }
            }
        )

    def until_end(self, command: dict) -> dict:
        """Answers questions until the last line of a run."""
        self.link.send(command)
        while True:
            question = self.link.receive()
            if question is None:
                return {"panicked": "the program ended"}
            for end in ("ended", "crashed", "refused", "panicked"):
                if end in question:
                    return question
            self.messages += 1
            if self.messages > 3_000:
                self.judge.blame("a run without an end")
                self.link.send({"crash": True})
                continue
            if "record" not in question and self.random.random() < self.scenario.crashes / 3:
                if "start" in question and self.random.random() < 0.5:
                    self.begin(question["start"])
                    self.finish()
                self.crash()
                continue
            answer = self.answer(question)
            if self.random.random() < self.scenario.signal / 3 and "crash" not in answer:
                answer["signal"] = True
                self.given.add("signal")
            self.link.send(answer)

    def crash(self) -> None:
        """The program is killed; an order under way may be done all the same."""
        if self.under_way is not None and self.random.random() < 0.5:
            self.finish()
        self.under_way = None
        self.link.send({"crash": True})

    # --- questions ------------------------------------------------------------------------------------------

    def answer(self, question: dict) -> dict:
        """The answer to a question."""
        if "record" in question:
            return self.record(question["record"])
        if "approve" in question:
            return self.approve(question["approve"], "need" in question or self.scenario.direct)
        if "judge" in question:
            return self.tell(question["judge"])
        if "confirm" in question:
            return self.confirm(question["confirm"])
        if "start" in question:
            return self.start(question)
        if "observe" in question:
            return self.observe("need" in question)
        if "poll" in question:
            return self.poll()
        if "stop" in question:
            self.stopped, self.under_way = True, None
            return {} if self.random.random() < 0.9 else {"error": "timed-out"}
        if "called" in question:
            return self.called(question["called"])
        if question.get("need") == "wait":
            return self.wait()
        self.judge.blame("an unknown question", str(question))
        return {"crash": True}

    def record(self, lines: list[str]) -> dict:
        """Keeps events, unless the program is killed while it writes."""
        if self.random.random() < self.scenario.crashes:
            kept = self.random.randrange(len(lines) + 1)
            self.keep(lines[:kept])
            if kept < len(lines):
                self.torn = lines[kept][: self.random.randrange(len(lines[kept]))]
            if self.under_way is not None and self.random.random() < 0.5:
                self.finish()
            self.under_way = None
            return {"crash": True}
        self.keep(lines)
        return {}

    def keep(self, lines: list[str]) -> None:
        """Judges lines that are on the disk."""
        for line in lines:
            self.log.append(line)
            event = json.loads(line)
            if event["event"] == "ordered":
                self.last_done = False
            self.judge.event(event)

    def approve(self, proposal: dict, direct: bool) -> dict:
        """A person decides."""
        draw = self.random.random()
        answer: bool | None = True
        if draw < self.scenario.person.refuses:
            answer = False
            self.given.add("refused")
        elif draw < self.scenario.person.refuses + self.scenario.person.leaves:
            answer = None
            self.given.add("no answer")
        self.judge.propose(proposal, answer)
        self.proposals.append(proposal["id"])
        if not direct:
            return {"answer": answer}
        if answer is None:
            return {"signal": True}
        if answer is False:
            return {"call": "refuse"}
        if self.random.random() < 0.3:
            wrong = self.random.choice([*self.proposals[:-1], "0" * 32])
            if wrong != proposal["id"]:
                refused = self.call({"call": "approve", "id": wrong})
                if refused is None:
                    self.judge.blame("an approval of another proposal counts", wrong)
        return {"call": "approve", "id": proposal["id"]}

    def call(self, call: dict):
        """Calls the interface directly; returns why it refused."""
        self.link.send(call)
        reply = self.link.receive()
        return reply.get("called")

    def called(self, refused: str | None) -> dict:
        """After a call that fits: an observation that means nothing fails the robot, and nothing else is refused."""
        if refused is None:
            return {}
        if "look" not in self.given:
            self.judge.blame("a call that fits is refused", refused)
        self.given.add("robot")
        return {"call": "robot_failed"}

    def tell(self, question: dict) -> dict:
        """A person says whether an order was done, truthfully."""
        done = self.last_done
        if self.random.random() < 0.1:
            self.given.add("no answer")
            return {"signal": True} if self.scenario.direct else {"answer": None}
        self.judge.answer = done
        if self.scenario.direct:
            return {"call": "judged", "order": question["order"], "done": done}
        return {"answer": done}

    def confirm(self, question: dict) -> dict:
        """A person looks whether something is so, and mostly says what they see."""
        read = self.judge.sentences.read(question["what"])
        if read is None:
            self.judge.blame("a sentence without a meaning", question["what"])
            return {"crash": True}
        key, value = read
        holds: bool | None = self.robot.value(key, self.robot.state) == value
        if self.random.random() < 0.1:
            self.given.add("no answer")
            return {"signal": True} if self.scenario.direct else {"answer": None}
        if self.random.random() < self.scenario.person.answers_wrong:
            holds = not holds
        if not holds:
            self.given.add("denies")
        self.judge.confirming = (question["what"], holds)
        if self.scenario.direct:
            return {"call": "confirmed", "holds": holds}
        return {"answer": holds}

    # --- the robot ------------------------------------------------------------------------------------------

    last_done = False

    def begin(self, order: dict) -> None:
        """The robot gets an order."""
        action = action_of(self.scenario.world, order)
        self.judge.started(action, self.stopped)
        self.under_way = (order["step"], action)
        self.last_done = False
        self.ticks = self.random.randint(0, self.scenario.faults.ticks)

    def finish(self) -> dict:
        """The robot ends the order under way."""
        if self.under_way is None:
            return {}
        _, action = self.under_way
        self.under_way = None
        before = self.robot.state
        try:
            result, why = self.robot.perform(action)
        except Died as died:
            self.last_done = before.key() != self.robot.state.key()
            self.given.add("robot")
            return {"error": str(died)}
        self.last_done = result == "done"
        return {"done": None} if result == "done" else {"failed": why}

    def start(self, question: dict) -> dict:
        """An order."""
        self.begin(question["start"])
        if question.get("need") == "order" and self.random.random() < 0.15:
            self.hostile(question["start"]["step"])
        return {}

    def poll(self) -> dict:
        """The state of the order under way."""
        if self.ticks > 0:
            self.ticks -= 1
            return {"running": None}
        return self.finish()

    def observe(self, direct: bool) -> dict:
        """A look."""
        try:
            seen = self.robot.look()
        except Died:
            self.given.add("look")
            return {"call": "robot_failed"} if direct else {"error": "gone"}
        if "<nobody_77>" in seen["states"]:
            self.given.add("look")
        self.judge.last_look = seen
        return {"call": "observed", "observation": seen} if direct else {"observation": seen}

    def wait(self) -> dict:
        """In a direct run: the end of the order under way."""
        number = max(self.judge.orders, default=0)
        result = self.finish()
        if "error" in result:
            return {"call": "robot_failed"}
        if "failed" in result:
            return {"call": "failed", "order": number}
        if self.random.random() < 0.1:
            self.hostile(number)
        return {"call": "performed", "order": number}

    def hostile(self, number: int) -> None:
        """Calls that do not fit: each has to be refused, and to change nothing."""
        ended = [own.number for own in self.judge.orders.values() if own.end != "under way"]
        for call in self.random.sample(
            [
                {"call": "performed", "order": 99},
                {"call": "failed", "order": 98},
                {"call": "performed", "order": self.random.choice(ended or [97])},
                {"call": "failed", "order": self.random.choice(ended or [96])},
                {"call": "judged", "order": number, "done": True},
                {"call": "approve", "id": "0" * 32},
                {"call": "refuse"},
            ],
            2,
        ):
            if self.call(call) is None:
                self.judge.blame("a call that does not fit is accepted", str(call))


class Link:
    """The pipe to the program."""

    def __init__(self, program):
        self.program = program

    def send(self, message: dict) -> None:
        """Writes a line."""
        self.program.stdin.write(json.dumps(message) + "\n")
        self.program.stdin.flush()

    def receive(self) -> dict | None:
        """Reads a line; none if the program has ended."""
        line = self.program.stdout.readline()
        return json.loads(line) if line else None
