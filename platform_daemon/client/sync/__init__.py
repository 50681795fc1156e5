"""The asynchronous client; `python -m tests.kit.sync_client` writes the other one from it."""
