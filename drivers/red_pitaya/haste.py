"""How long a board is waited for while power may be on."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

LAST_LOOK_S = 0.05  # a computer may have stood still itself, and a card that is well still answers


@dataclass(frozen=True)
class Haste:
    """most_s: without an answer or a sample; until_s: for all of them together, on the monotonic clock."""

    most_s: float
    until_s: float = math.inf

    def left_s(self) -> float:
        """How long the next may take."""
        return max(min(self.most_s, self.until_s - time.monotonic()), LAST_LOOK_S)
