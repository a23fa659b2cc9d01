class _Leaf(NamedTuple):
    """A leaf that a tree can have: its ports, its function, the type of its result, and the words for its outcomes."""

    ports: list[str]
    call: Callable[[Robot, list[str]], Any]
    result: type[Any]
    words: Optional[Callable[[list[str]], list[list[str]]]] = None


def outcome_words(outcomes: list[list[str]]) -> list[str]:
    """Returns the words for outcomes, each different from those before it."""
    words: list[str] = []
    for parts in outcomes:
        word = "_".join(re.sub(r"[^A-Za-z0-9_-]", "_", part.strip("<>")) for part in parts)
        while word in words:
            word += "_"
        words.append(word)
    return words


class Tree:
    """A behavior tree of `longstep export --format bt`, ticked by BehaviorTree.CPP.

    `behaviortreepy` has no ports for nodes in Python, so the leaves keep their arguments here, by the names of their nodes.
    """

    def __init__(self, xml: str, robot: Robot) -> None:
        self._library: Any = importlib.import_module("behaviortreepy")
        self._robot = robot
        self._calls: dict[str, tuple[_Leaf, list[str], Optional[str]]] = {}
        self._tasks: dict[int, Task[Any]] = {}
        self._error: Optional[BaseException] = None
        factory = self._library.BehaviorTreeFactory()
        for name, leaf in _LEAVES.items():
            if leaf.result is not bool:
                factory.register_simple_stateful_action(name, self._start, self._running, self._halted)
            else:
                factory.register_simple_condition(name, self._holds)
        self._tree: Any = factory.create_tree_from_text(self._without_ports(xml))
        # The tree refers to functions that the factory has.
        self._factory: Any = factory

    def tick(self) -> Optional[bool]:
        """Ticks the tree once. Returns True if it has succeeded, False if it has failed, and None if it is running.

        An exception from the robot halts all actions that have begun, and is raised again.
        """
        status = self._tree.tick_once()
        if self._error is not None:
            error, self._error = self._error, None
            self.halt()
            raise error
        if status == self._library.NodeStatus.RUNNING:
            return None
        return bool(status == self._library.NodeStatus.SUCCESS)

    def halt(self) -> None:
        """Halts all actions that have begun."""
        try:
            self._tree.halt_tree()
        finally:
            while self._tasks:
                self._halt_task(self._tasks.popitem()[1])
        if self._error is not None:
            error, self._error = self._error, None
            raise error

    def run(self, pause: float = 0.01) -> bool:
        """Ticks the tree to its end, with pauses in seconds. Returns True if it has succeeded. Nothing goes on after an
        exception, Ctrl-C included."""
        try:
            while True:
                result = self.tick()
                if result is not None:
                    return result
                time.sleep(pause)
        except BaseException:
            self.halt()
            raise

    def _without_ports(self, xml: str) -> str:
        root = ElementTree.fromstring(xml)
        for model in root.findall("TreeNodesModel"):
            root.remove(model)
        for tree in root.findall("BehaviorTree"):
            for node in tree.iter():
                name = node.get("ID", "") if node.tag in ("Action", "Condition") else node.tag
                leaf = _LEAVES.get(name)
                if leaf is not None:
                    self._take_ports(node, name, leaf)
        return ElementTree.tostring(root, encoding="unicode")

    def _take_ports(self, node: ElementTree.Element, name: str, leaf: _Leaf) -> None:
        ports = {key: text for key, text in node.attrib.items() if key not in ("ID", "name") and not key.startswith("_")}
        entry = ports.pop("outcome", None) if leaf.words is not None else None
        if sorted(ports) != sorted(leaf.ports):
            raise ValueError(f"`{name}` has the ports {sorted(ports)}, and needs {sorted(leaf.ports)}")
        texts = [ports[port] for port in leaf.ports]
        for text in texts:
            if text.startswith("{") and text.endswith("}"):
                raise ValueError(f"`{name}` has {text} from the blackboard, and needs the name of an entity")
        for port in [*ports, "outcome"]:
            node.attrib.pop(port, None)
        unique = f"{node.get('name', name)} #{len(self._calls) + 1}"
        node.set("name", unique)
        self._calls[unique] = (leaf, texts, None if entry is None else entry.strip("{}"))

    def _guarded(self, call: Callable[[], Any]) -> Any:
        """Calls the robot. After an exception, which the library would take for a failure, nothing begins any more."""
        if self._error is not None:
            return self._library.NodeStatus.FAILURE
        try:
            return call()
        except BaseException as error:
            self._error = error
            return self._library.NodeStatus.FAILURE

    def _start(self, node: Any) -> Any:
        def begin() -> Any:
            leaf, texts, _ = self._calls[node.name()]
            self._tasks[node.uid()] = leaf.call(self._robot, texts)
            return self._looked(node)

        return self._guarded(begin)

    def _running(self, node: Any) -> Any:
        return self._guarded(lambda: self._looked(node))

    def _looked(self, node: Any) -> Any:
        task = self._tasks[node.uid()]
        result = task.poll()
        if result is Status.RUNNING:
            return self._library.NodeStatus.RUNNING
        del self._tasks[node.uid()]
        if result is Status.FAILED:
            return self._library.NodeStatus.FAILURE
        leaf, texts, entry = self._calls[node.name()]
        if not isinstance(result, leaf.result):
            raise TypeError(f"`{node.name()}` has the result {result!r}, and needs one of {leaf.result.__name__}")
        if leaf.words is not None:
            outcomes: Any = leaf.result
            place = list(outcomes).index(result)
            word = outcome_words(leaf.words(texts))[place]
            if entry is not None:
                node.config().blackboard.set_string(entry, word)
        return self._library.NodeStatus.SUCCESS

    def _halted(self, node: Any) -> None:
        task = self._tasks.pop(node.uid(), None)
        if task is not None:
            self._halt_task(task)

    def _halt_task(self, task: Task[Any]) -> None:
        try:
            task.halt()
        except BaseException as error:
            if self._error is None:
                self._error = error

    def _holds(self, node: Any) -> Any:
        leaf, texts, _ = self._calls[node.name()]
        status = self._library.NodeStatus
        return self._guarded(lambda: status.SUCCESS if leaf.call(self._robot, texts) else status.FAILURE)


def load(xml: str, robot: Robot) -> Tree:
    """Returns the tree of a text in XML, with the robot's functions as its leaves."""
    return Tree(xml, robot)


