"""What crosses a boundary: requests, results, jobs, problems.

SelfTestOptions: Table `[self_test]` of a platform file.
"""

from .requests import SelfTestOptions

__all__ = ["SelfTestOptions"]
