"""Which connections there are, whose, and which of them may have to make room."""

from __future__ import annotations

import itertools
from collections import Counter
from typing import Generic, TypeVar

from .limits import Limits

LinkT = TypeVar("LinkT")


class Room(Generic[LinkT]):
    """For one event loop.

    Attributes:
        unheard: connections that have asked nothing yet, the oldest first.
        answered: those that have had their answers and say nothing more, first those that have done so for longest.
        unfinished: those whose request has begun and whose body is not whole, the oldest first.
        leaving: those that were turned away and are not gone, the oldest first: TLS waits for the other end to say that
            it goes, too.  They count no more.
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._whose: dict[LinkT, str] = {}
        self._of_one = Counter[str]()
        self.unheard: dict[LinkT, None] = {}
        self.answered: dict[LinkT, None] = {}
        self.unfinished: dict[LinkT, None] = {}
        self.leaving: dict[LinkT, None] = {}

    def enter(self, link: LinkT, client: str) -> None:
        """Another connection of a client."""
        self._whose[link] = client
        self._of_one[client] += 1

    def leave(self, link: LinkT) -> None:
        """It has gone, or is going.  Idempotent."""
        client = self._whose.pop(link, None)
        if client is not None:
            self._of_one[client] -= 1
            if not self._of_one[client]:
                del self._of_one[client]
        self.leave_quiet(link)
        self.unfinished.pop(link, None)
        self.leaving.pop(link, None)

    def turn_away(self, link: LinkT) -> LinkT | None:
        """It is going; of too many that are, the one to be cut off."""
        self.leave(link)
        self.leaving[link] = None
        return next(iter(self.leaving)) if len(self.leaving) > self._limits.handshakes else None

    def leave_quiet(self, link: LinkT) -> None:
        """Its client has said something."""
        self.unheard.pop(link, None)
        self.answered.pop(link, None)

    def too_many_of(self, client: str) -> bool:
        """Has this client more than its share?"""
        return self._of_one[client] > self._limits.connections_per_client

    @property
    def too_many(self) -> bool:
        """Are there more than there may be?"""
        return len(self._whose) > self._limits.connections

    def who_leaves(self, newcomer: LinkT, client: str | None) -> LinkT | None:
        """Who makes room for a newcomer; client: one of its connections, None: any.

        Rather one that never asked anything, then one that has said nothing for long, then one that has kept its
        request to itself for longest: a body is there at once, or somebody holds it back.
        """
        able = itertools.chain(self.unheard, self.answered, self.unfinished)
        return next((each for each in able if each is not newcomer and client in (None, self._whose.get(each))), None)
