"""Ticks behavior trees with a generated module: `scripted.py MODULE.py`. The language on standard input and output is that of
tools/peers/behavior_trees/runner.cpp; the answer `exception` raises one."""

import importlib.util
import inspect
import sys
import typing

halts = False


def answer(question):
    print(question, flush=True)
    line = sys.stdin.readline()
    if not line:
        sys.exit(3)
    return line.rstrip("\n")


def asked(nodes, call, result):
    first = [answer(f"do\t{call}")]
    if first == ["exception"]:
        raise RuntimeError("exception")

    class Asked(nodes.Task):
        def poll(self):
            global halts
            line = first.pop() if first else answer(f"still\t{call}")
            if line == "halt":
                halts = True
            if line in ("later", "halt"):
                return nodes.Status.RUNNING
            if line == "failure":
                return nodes.Status.FAILED
            word = line.partition("\t")[2]
            return result[word] if word else result.DONE

        def halt(self):
            print(f"halted\t{call}", flush=True)

    return Asked()


def function(nodes, name, own):
    ports = [port.rstrip("_") for port in inspect.signature(own).parameters][1:]
    result = typing.get_type_hints(own, vars(nodes))["return"]

    def scripted(self, *texts):
        call = "\t".join([name.rstrip("_"), *(f"{port}={text}" for port, text in zip(ports, texts, strict=True))])
        if result is bool:
            return answer(f"ask\t{call}") == "success"
        return asked(nodes, call, typing.get_args(result)[0])

    return scripted


def main():
    global halts
    spec = importlib.util.spec_from_file_location("nodes", sys.argv[1])
    nodes = importlib.util.module_from_spec(spec)
    sys.modules["nodes"] = nodes
    spec.loader.exec_module(nodes)
    own = {name: member for name, member in vars(nodes.Robot).items() if inspect.isfunction(member)}
    robot = type("Scripted", (nodes.Robot,), {name: function(nodes, name, member) for name, member in own.items()})()
    while path := sys.stdin.readline().rstrip("\n"):
        try:
            with open(path, encoding="utf-8") as file:
                tree = nodes.load(file.read(), robot)
        except (ValueError, RuntimeError) as error:
            print(f"refused\t{error}".replace("\n", " "), flush=True)
            continue
        halts = False
        try:
            status = tree.tick()
            while status is None and not halts:
                status = tree.tick()
        except RuntimeError as error:
            print("end\tEXCEPTION" if str(error) == "exception" else f"end\t{error}", flush=True)
            continue
        if halts:
            tree.halt()
        print("end\t" + ("HALTED" if halts else "SUCCESS" if status else "FAILURE"), flush=True)


main()
