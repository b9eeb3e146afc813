"""What an executor asks for work: base of action clients and servers."""

from ._entity import Entity as Waitable

__all__ = ["Waitable"]
