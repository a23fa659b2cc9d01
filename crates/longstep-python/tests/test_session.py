"""Sessions with a function as the model."""

from __future__ import annotations

import gc
import json
import threading
import unittest
import weakref
from typing import Any, cast

import longstep
from scenes import DESK, ROOT, Recorder, desk, reply


class Sessions(unittest.TestCase):
    def test_a_request_is_one_for_chat_completions(self) -> None:
        seen: list[longstep.Request] = []

        def model(request: longstep.Request) -> str:
            seen.append(request)
            return reply("put(pen, shelf)")

        session = longstep.Session(desk(), model, temperature=0.5)
        answer = session.instruct("The pen belongs on the shelf")
        request = seen[0]
        self.assertEqual(set(request), {"messages", "temperature", "max_tokens", "response_format"})
        self.assertEqual(request["messages"][0]["role"], "system")
        self.assertIn("The pen belongs on the shelf", request["messages"][-1]["content"])
        self.assertEqual(request["temperature"], 0.5)
        self.assertIn("goal", request["response_format"]["json_schema"]["schema"]["properties"])
        self.assertEqual((answer.status, session.status), ("verified", "plan"))

    def test_the_world_is_carried_on(self) -> None:
        goals = iter(["put(pen, shelf)", "put(pen, desk)"])
        session = longstep.Session(desk(), lambda _: reply(next(goals)))
        session.instruct("The pen belongs on the shelf")
        self.assertEqual(session.accept().goal, ["put(<pen>, <shelf>)"])
        self.assertEqual(session.world.environment()["object_states"]["<pen>"], "on_something(<shelf>)")
        plan = session.instruct("Now back to the desk, please, the pen").verified()
        self.assertEqual(plan.world, session.world)
        session.accept()
        self.assertEqual([len(own) for own in session.accepted], [6, 6])
        self.assertEqual(session.undo(), 1)
        self.assertEqual(session.world.environment()["object_states"]["<pen>"], "on_something(<shelf>)")

    def test_a_question_is_answered(self) -> None:
        replies = iter([reply(question="Which one?"), reply("put(pen, shelf)")])
        session = longstep.Session(desk(), lambda _: next(replies))
        asked = session.instruct("Put it on the shelf")
        self.assertEqual((asked.status, asked.question, session.status), ("question", "Which one?", "question"))
        with self.assertRaises(longstep.Question):
            asked.verified()
        self.assertEqual(len(session.answer("the pen").verified()), 6)

    def test_a_plan_with_a_question_is_accepted_by_consent_alone(self) -> None:
        asked = reply("put(pen, shelf)", question="Do you mean the pen?")
        partial = reply("put(pen, shelf)", left_out=("but only if Anna is not there",))
        for own, left_out in ((asked, []), (partial, ["only if Anna is not there"])):
            session = longstep.Session(desk(), lambda _, own=own: own)
            answer = session.instruct("Put the pen on the shelf, but only if Anna is not there")
            with self.subTest(own):
                self.assertEqual((answer.status, session.status, answer.plan), ("question", "consent", None))
                offer = answer.offer
                assert offer is not None
                self.assertEqual((len(offer), offer.goal), (6, ["put(<pen>, <shelf>)"]))
                with self.assertRaises(longstep.Question) as unclear:
                    answer.verified()
                self.assertIn("consent", cast(str, unclear.exception.hint))
                with self.assertRaises(longstep.LongstepError) as refused:
                    session.accept()
                self.assertIn(answer.question, str(refused.exception))
                self.assertIn("accept(consent=True)", cast(str, refused.exception.hint))
                self.assertEqual((session.accepted, session.status), ([], "consent"))
                plan = session.accept(consent=True)
                self.assertEqual(plan.json(), session.accepted[0].json())
                self.assertTrue(set(left_out) <= {words.removeprefix("but ") for words in plan.left_out}, plan.left_out)

    def test_the_loop_of_the_guide_shows_every_question(self) -> None:
        guide = (ROOT / "docs" / "guide" / "python.md").read_text(encoding="utf-8")
        begin = guide.index("answer = session.instruct(")
        loop = guide[begin : guide.index("```", begin)]
        replies = iter([
            reply(question="Which one?"),
            reply("put(pen, shelf)", question="Is the desk free?"),
        ])
        session = longstep.Session(desk(), lambda _: next(replies))
        shown: list[str] = []
        people = iter(["the pen", "y"])

        def ask(question: str = "") -> str:
            shown.append(question)
            return next(people)

        names: dict[str, Any] = {"session": session, "input": ask, "print": lambda *words: shown.extend(map(str, words))}
        exec(loop, names)
        self.assertEqual((len(names["plan"]), session.status), (6, "ready"))
        self.assertEqual(shown[0], "Which one?")
        self.assertIn("move the hand to the pen", shown[1])
        self.assertEqual(shown[2], names["answer"].question)

    def test_a_plan_without_a_question_offers_nothing(self) -> None:
        session = longstep.Session(desk(), lambda _: reply("put(pen, shelf)"))
        answer = session.instruct("The pen belongs on the shelf")
        self.assertIsNone(answer.offer)
        self.assertEqual(session.accept(consent=True).left_out, [])

    def test_words_out_of_turn_change_nothing(self) -> None:
        session = longstep.Session(desk(), lambda _: reply("put(pen, shelf)"))
        for call in (session.accept, session.undo, session.cancel, lambda: session.answer("yes")):
            with self.assertRaises(longstep.LongstepError):
                cast(Any, call)()
        for empty in ("", "  \n"):
            with self.assertRaises(longstep.Unreadable):
                session.instruct(empty)
        self.assertEqual(session.status, "ready")

    def test_rules_bind_later_plans(self) -> None:
        session = longstep.Session(desk(), lambda _: reply("put(pen, shelf)"))
        session.add_rule("untouched(pen)")
        self.assertEqual(session.rules, ["untouched(<pen>)"])
        self.assertEqual(session.instruct("The pen belongs on the shelf").status, "unsolvable")
        session.cancel()
        self.assertEqual(session.lift_rule(0), "untouched(<pen>)")
        self.assertEqual(session.instruct("The pen belongs on the shelf").status, "verified")

    def test_an_exception_of_the_model_comes_out_as_itself(self) -> None:
        class Broken(Exception):
            pass

        error = Broken("no power")
        fails = True

        def model(_: longstep.Request) -> str:
            if fails:
                raise error
            return reply("put(pen, shelf)")

        session = longstep.Session(desk(), model)
        with self.assertRaises(Broken) as raised:
            session.instruct("The pen belongs on the shelf")
        self.assertIs(raised.exception, error)
        fails = False
        self.assertEqual(session.instruct("The pen belongs on the shelf").status, "verified")

    def test_a_reply_that_is_no_text_is_a_type_error(self) -> None:
        session = longstep.Session(desk(), cast(Any, lambda _: {"goal": "put(pen, shelf)"}))
        with self.assertRaises(TypeError):
            session.instruct("The pen belongs on the shelf")

    def test_a_model_that_uses_its_session_gets_an_error_and_no_deadlock(self) -> None:
        def model(_: longstep.Request) -> str:
            session.instruct("Again")
            return reply("put(pen, shelf)")

        session = longstep.Session(desk(), model)
        with self.assertRaisesRegex(longstep.LongstepError, "at work") as raised:
            session.instruct("The pen belongs on the shelf")
        self.assertIn("a model cannot use the session that calls it", cast(str, raised.exception.hint))

    def test_a_second_thread_gets_an_error_while_the_model_works(self) -> None:
        working, go_on = threading.Event(), threading.Event()

        def model(_: longstep.Request) -> str:
            working.set()
            self.assertTrue(go_on.wait(60))
            return reply("put(pen, shelf)")

        session = longstep.Session(desk(), model)
        answers: list[longstep.Answer] = []
        thread = threading.Thread(target=lambda: answers.append(session.instruct("The pen belongs on the shelf")))
        thread.start()
        self.assertTrue(working.wait(60))
        with self.assertRaisesRegex(longstep.LongstepError, "at work"):
            session.instruct("Something else")
        go_on.set()
        thread.join()
        self.assertEqual(answers[0].status, "verified")

    def test_a_session_that_its_model_refers_to_is_collected(self) -> None:
        class Agent:
            def __init__(self) -> None:
                self.session = longstep.Session(desk(), self.model)

            def model(self, _: longstep.Request) -> str:
                gc.collect()
                return reply("put(pen, shelf)")

        agents = [Agent() for _ in range(10)]
        self.assertEqual(agents[0].session.instruct("The pen belongs on the shelf").status, "verified")
        self.assertIn(agents[0].model, gc.get_referents(agents[0].session))
        alive = [weakref.ref(agent) for agent in agents]
        agents.clear()
        gc.collect()
        self.assertEqual([own for own in alive if own() is not None], [])

    def test_a_model_that_is_no_callable_is_a_type_error(self) -> None:
        with self.assertRaisesRegex(TypeError, "the model must be callable, not str"):
            longstep.Session(desk(), cast(Any, "gpt-4.1"))

    def test_the_next_instruction_begins_in_the_world_that_a_run_saw(self) -> None:
        session = longstep.Session(desk(), lambda _: reply("put(pen, shelf)"))
        session.instruct("The pen belongs on the shelf")
        plan = session.accept()
        for robot, done, changes in (
            (Recorder(desk()), False, ["the pen is not on the shelf any more", "the pen is on the desk"]),
            (longstep.Sim(desk()), True, ["the pen is not on the desk any more", "the pen is on the shelf"]),
        ):
            run = longstep.run(plan, robot, approve="never" if done else "changes")
            self.assertEqual((run.is_done, session.carried_out(run)), (done, changes))
            place = "on_something(<shelf>)" if done else "on_something(<desk>)"
            self.assertEqual(session.world.environment()["object_states"]["<pen>"], place)
        with self.assertRaisesRegex(longstep.LongstepError, "no accepted plan waits"):
            session.carried_out(run)
        self.assertEqual([json.loads(line)["event"] for line in session.log().splitlines()].count("carried_out"), 2)

    def test_the_run_of_another_plan_is_refused(self) -> None:
        session = longstep.Session(desk(), lambda _: reply("put(pen, shelf)"))
        session.instruct("The pen belongs on the shelf")
        session.accept()
        other = longstep.solve(desk(), "put(pen, shelf) then put(pen, desk)").verified()
        run = longstep.run(other, longstep.Sim(desk()), approve="never")
        with self.assertRaisesRegex(longstep.LongstepError, "another plan"):
            session.carried_out(run)
        self.assertEqual(session.observed(run.world), ["the pen is not on the shelf any more", "the pen is on the desk"])

    def test_the_next_instruction_begins_in_the_world_that_was_seen(self) -> None:
        moved = longstep.World({**DESK, "object_states": {"<pen>": "on_something(<shelf>)"}})
        observation: longstep.Observation = {"states": {"<pen>": ["on_something(<shelf>)"]}}
        for seen in (moved, observation):
            session = longstep.Session(desk(), lambda _: reply("put(pen, desk)"))
            self.assertEqual(session.observed(seen), ["the pen is not on the desk any more", "the pen is on the shelf"])
            self.assertEqual(len(session.instruct("The pen belongs on the desk").verified()), 6)
            with self.assertRaisesRegex(longstep.LongstepError, "does not fit here"):
                session.observed(seen)
        session = longstep.Session(desk(), lambda _: reply())
        wrong: list[tuple[object, type[Exception], str]] = [
            ([], TypeError, "an observation must be .* not list"),
            ({"states": {"pen": []}}, ValueError, "the observation names .*did you mean `<pen>`"),
            ({"states": {"<pen>": ["flying()"]}}, longstep.Unreadable, "flying"),
            (longstep.World({"assets": ["<desk>"]}, domain="household-dual"), longstep.Unreadable, "household-dual"),
        ]
        for value, error, message in wrong:
            with self.subTest(value), self.assertRaisesRegex(error, message):
                session.observed(cast(Any, value))

    def test_the_log_has_every_event(self) -> None:
        session = longstep.Session(desk(), lambda _: reply("put(pen, shelf)"), name="scripted")
        session.instruct("The pen belongs on the shelf")
        first = session.log()
        session.accept()
        lines = [json.loads(line) for line in session.log().splitlines()]
        self.assertTrue(session.log().startswith(first))
        events = [line["event"] for line in lines]
        self.assertEqual(events[0], "begin")
        self.assertIn("accept", events)

    def test_a_reply_counts_as_one_call(self) -> None:
        # A replay of the log counts so too.
        session = longstep.Session(desk(), lambda _: reply("put(pen, shelf)"))
        answer = session.instruct("The pen belongs on the shelf")
        self.assertEqual(answer.dict()["usage"]["calls"], 1)


if __name__ == "__main__":
    unittest.main()
