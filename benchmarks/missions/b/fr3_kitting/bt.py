"""A very small behaviour tree: what the kitting cell needs, and no more."""
from enum import Enum


class Status(Enum):
    SUCCESS = "success"
    FAILURE = "failure"


class Node:
    def __init__(self, name):
        self.name = name

    def tick(self):
        raise NotImplementedError


class Do(Node):
    """A leaf around a callable; what it returns, if false, is a failure."""

    def __init__(self, name, function, *args):
        super().__init__(name)
        self.function = function
        self.args = args

    def tick(self):
        done = self.function(*self.args)
        return Status.SUCCESS if done or done is None else Status.FAILURE


class Composite(Node):
    def __init__(self, name, children):
        super().__init__(name)
        self.children = list(children)


class Sequence(Composite):
    """All children, until one fails."""

    def tick(self):
        for child in self.children:
            if child.tick() is Status.FAILURE:
                return Status.FAILURE
        return Status.SUCCESS


class Fallback(Composite):
    """The children until one succeeds."""

    def tick(self):
        for child in self.children:
            if child.tick() is Status.SUCCESS:
                return Status.SUCCESS
        return Status.FAILURE


class Retry(Composite):
    """Its only child, again and again."""

    def __init__(self, name, child, attempts):
        super().__init__(name, [child])
        self.attempts = attempts

    def tick(self):
        for _ in range(self.attempts):
            if self.children[0].tick() is Status.SUCCESS:
                return Status.SUCCESS
        return Status.FAILURE


class Inverter(Composite):
    def __init__(self, name, child):
        super().__init__(name, [child])

    def tick(self):
        failed = self.children[0].tick() is Status.FAILURE
        return Status.SUCCESS if failed else Status.FAILURE
