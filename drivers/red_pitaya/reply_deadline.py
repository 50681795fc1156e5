"""How long a board is waited for while power may be on."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

MIN_WAIT_S = 0.05  # a computer may have stood still itself, and a card that is well still answers


@dataclass(frozen=True)
class ReplyDeadline:
    """timeout_s: without an answer or a sample; deadline_s: for all of them together, on the monotonic clock."""

    timeout_s: float
    deadline_s: float = math.inf

    def remaining_s(self) -> float:
        """How long the next may take."""
        return max(min(self.timeout_s, self.deadline_s - time.monotonic()), MIN_WAIT_S)
