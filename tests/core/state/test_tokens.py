"""The file of the tokens: hashes only, for its owner only, whole at every moment."""

import json
import os
import stat
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta

import pytest

from drivers.errors import ConfigError, InputError
from platform_daemon.core.schemas.access import Role
from platform_daemon.core.state.tokens import TokenFile, has_expired


@pytest.fixture
def tokens(tmp_path):
    return TokenFile(tmp_path / "data" / "tokens.json")


def test_a_token_is_long_random_and_nowhere_in_its_file(tokens):
    one, two = tokens.add("ann", Role.ADMIN), tokens.add("bob", Role.VIEWER)
    assert one != two
    assert len(one) >= 43
    text = tokens.path.read_text()
    assert one not in text
    assert one.removeprefix("pd_") not in text
    assert stat.S_IMODE(tokens.path.stat().st_mode) == 0o600
    assert [(r.name, r.role) for r in tokens.records()] == [("ann", Role.ADMIN), ("bob", Role.VIEWER)]
    assert tokens.holder(one).name == "ann"
    assert tokens.holder(one + "x") is None
    assert tokens.holder("") is None


@pytest.mark.parametrize("name", ["", "local", "a b", "-x", "x" * 61, "a/b", "é"])
def test_a_name_that_cannot_be_one_is_refused(tokens, name):
    with pytest.raises(InputError, match="no token can be called"):
        tokens.add(name, Role.VIEWER)
    assert not tokens.exists


def test_a_name_is_given_once_and_can_be_given_again_after_it_was_revoked(tokens):
    first = tokens.add("ann", Role.VIEWER)
    with pytest.raises(InputError, match="there is a token called 'ann'"):
        tokens.add("ann", Role.ADMIN)
    assert tokens.revoke("ann").role is Role.VIEWER
    assert tokens.exists
    assert tokens.holder(first) is None
    tokens.add("ann", Role.ADMIN)
    with pytest.raises(InputError, match="no token is called"):
        tokens.revoke("bob")


def test_a_moment_that_is_past_is_refused_and_one_to_come_is_kept(tokens):
    now = datetime.now(UTC)
    with pytest.raises(InputError, match="expired already"):
        tokens.add("ann", Role.VIEWER, now)
    tokens.add("ann", Role.VIEWER, now + timedelta(days=1))
    assert not has_expired(tokens.records()[0])


@pytest.mark.parametrize("mode", [0o620, 0o602, 0o666])
def test_a_file_that_others_may_write_is_not_believed(tokens, mode):
    tokens.add("ann", Role.ADMIN)
    tokens.path.chmod(mode)
    with pytest.raises(ConfigError, match="give themselves a token"):
        TokenFile(tokens.path).records()


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a file away")
def test_a_file_that_somebody_else_put_there_is_not_believed(tokens):
    tokens.add("ann", Role.ADMIN)
    os.chown(tokens.path, 12345, -1)
    with pytest.raises(ConfigError, match="belongs to uid 12345"):
        TokenFile(tokens.path).records()
    os.chown(tokens.path.parent, 12345, -1)  # their own folder, which root looks at
    assert len(TokenFile(tokens.path).records()) == 1


@pytest.mark.parametrize(
    "text",
    ["", "no", "{}", '{"tokens": 1}', '{"tokens": [], "more": 1}', "\udcff", "[" * 100_000],
    ids=["empty", "word", "nothing", "number", "more", "no text", "deep"],
)
def test_a_damaged_file_is_an_error_and_not_an_empty_one(tokens, text):
    tokens.add("ann", Role.ADMIN)
    tokens.path.write_text(text, errors="surrogateescape")
    with pytest.raises(ConfigError, match="no file of tokens"):
        TokenFile(tokens.path).records()


def test_a_folder_that_is_mistyped_is_not_made_by_taking_a_token_back(tokens):
    with pytest.raises(InputError, match=r"no token is called 'ann'.*--data"):
        tokens.revoke("ann")
    assert not tokens.path.parent.exists()


def test_commands_at_once_lose_nothing(tokens):
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda n: TokenFile(tokens.path).add(f"t{n}", Role.VIEWER), range(24)))
    assert len(tokens.records()) == len(json.loads(tokens.path.read_text())["tokens"]) == 24


@pytest.mark.parametrize("kind", ["link", "pipe"])
def test_what_is_no_file_of_its_own_is_not_believed_and_not_waited_for(tokens, tmp_path, kind):
    one = tokens.add("ann", Role.ADMIN)
    tokens.path.rename(tmp_path / "elsewhere")
    if kind == "link":
        tokens.path.symlink_to(tmp_path / "elsewhere")
    else:
        os.mkfifo(tokens.path, 0o600)
    with pytest.raises(ConfigError):
        TokenFile(tokens.path).holder(one)


def test_a_file_that_others_may_write_from_now_on_is_believed_no_more(tokens):
    one = tokens.add("ann", Role.ADMIN)
    assert tokens.holder(one).name == "ann"
    tokens.path.chmod(0o666)
    with pytest.raises(ConfigError, match="give themselves a token"):
        tokens.holder(one)


def test_a_folder_in_its_place_costs_no_descriptor(tokens):
    tokens.path.mkdir(parents=True)
    before = len(os.listdir("/proc/self/fd"))
    for _ in range(10):
        with pytest.raises(ConfigError, match="no link"):
            tokens.records()
    assert len(os.listdir("/proc/self/fd")) == before
