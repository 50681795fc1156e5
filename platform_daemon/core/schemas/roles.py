"""Roles of those who use the REST interface; without pydantic, because the help of `token add` lists them."""

from __future__ import annotations

from enum import StrEnum


class Role(StrEnum):
    """What the holder of a token may do; each role may do all that those before it may."""

    VIEWER = "viewer"
    OPERATOR = "operator"
    ADMIN = "admin"

    def covers(self, needed: Role) -> bool:
        """Is this role enough where `needed` is requested?"""
        order = list(Role)
        return order.index(self) >= order.index(needed)
