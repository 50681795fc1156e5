from .requests import SelfTestOptions as SelfTestOptions
from .requests import SequencePatch as SequencePatch
