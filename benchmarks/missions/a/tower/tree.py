"""A very small behaviour tree: nodes are callables that return True or False."""
import logging

log = logging.getLogger("tree")


class Action:
    def __init__(self, function, *args):
        self.function, self.args = function, args

    def __call__(self):
        result = self.function(*self.args)
        return True if result is None else bool(result)

    def __str__(self):
        return self.function.__name__ + str(self.args)


class Sequence:
    def __init__(self, *children):
        self.children = children

    def __call__(self):
        for child in self.children:
            if not child():
                log.warning("failed: %s", child)
                return False
        return True


class Fallback:
    def __init__(self, *children):
        self.children = children

    def __call__(self):
        return any(child() for child in self.children)


class Inverter:
    def __init__(self, child):
        self.child = child

    def __call__(self):
        return not self.child()


class Retry:
    def __init__(self, child, times):
        self.child, self.times = child, times

    def __call__(self):
        for _ in range(self.times):
            if self.child():
                return True
        return False
