"""What crosses a boundary: requests, results, jobs, problems, and the table of parameters with symbol and unit.

SelfTestOptions: The self-test before a series, table `[self_test]` of a platform file.
SequencePatch: The keys of a sequence that differ from the resonator's preset.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
