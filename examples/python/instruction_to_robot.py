"""From an instruction to a running robot, which is simulated here."""

import json
from pathlib import Path

import longstep


def model(request: longstep.Request) -> str:
    """Answers as a language model does. With OpenAI's client the body is:

    client.chat.completions.create(model="gpt-4.1", **request).choices[0].message.content
    """
    goal = "put(juice, shelf top)" if "juice" in request["messages"][-1]["content"] else ""
    return json.dumps({"goal": goal, "left_out": [], "question": "" if goal else "What do you mean?"})


environment = Path(__file__).parent.parent / "environments" / "pantry.json"
session = longstep.Session(longstep.World(environment), model)
answer = session.instruct("Put the juice on top of the shelf")
print(answer.verified())  # raises longstep.Question if the model asks

robot = longstep.Sim(session.world, faults=1, kinds=["slips"], seed=5)  # or an object of your own
plan = session.accept()
run = longstep.run(plan, robot, approve="never")
print("done" if run.is_done else run.stopped, f"after {run.changes} change(s) of the plan")
assert run.is_done
