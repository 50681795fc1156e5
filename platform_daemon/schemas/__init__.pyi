from .requests import SelfTestOptions as SelfTestOptions
