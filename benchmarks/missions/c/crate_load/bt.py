"""A behaviour tree as small as it gets: a node is a callable that returns True or False."""


class Node:
    def __init__(self, name):
        self.name = name

    def __call__(self, log):
        raise NotImplementedError


class Do(Node):
    def __init__(self, name, action, *args):
        super().__init__(name)
        self.action = action
        self.args = args

    def __call__(self, log):
        outcome = self.action(*self.args)
        good = True if outcome is None else bool(outcome)
        if not good:
            log.warning(f"'{self.name}' failed")
        return good


class Sequence(Node):
    def __init__(self, name, *children):
        super().__init__(name)
        self.children = children

    def __call__(self, log):
        return all(child(log) for child in self.children)


class Fallback(Sequence):
    def __call__(self, log):
        return any(child(log) for child in self.children)


class Twice(Node):
    """Tries its child a second time if it fails."""

    def __init__(self, child):
        super().__init__(child.name)
        self.child = child

    def __call__(self, log):
        return self.child(log) or self.child(log)
