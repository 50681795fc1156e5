"""What the campaign of killed reproductions notices, and what its page says."""

from tests.campaigns.reproduce_kills import PHASES, Found, changed, digest, page


def test_a_file_that_is_another_one_after_a_death_is_named(tmp_path):
    files = [tmp_path / name for name in ("thread.h5", "part-0.json")]
    for file in files:
        file.write_bytes(b"whole")
    kept = {file: digest(file) for file in files}
    assert changed(kept) == []
    files[0].write_bytes(b"measured twice")
    assert changed(kept) == ["thread.h5 has changed"]


def test_a_phase_is_seen_in_the_folder(tmp_path):
    def reached():
        return [phase for phase, seen in PHASES.items() if seen(tmp_path)]

    assert reached() == []
    (tmp_path / ".thread.h5.shots").mkdir()
    assert reached() == []
    (tmp_path / ".thread.h5.shots" / "shot_000000.h5").touch()
    assert reached() == ["measuring the thread"]
    (tmp_path / "jewel.h5").touch()  # and no log with an outcome
    (tmp_path / "noise-parts").mkdir()
    (tmp_path / "noise-parts" / "part-00000.json").touch()
    (tmp_path / "noise.json").touch()
    assert reached() == list(PHASES)


def test_the_page_has_a_row_per_phase_and_what_is_wrong():
    text = page(Found(dict.fromkeys(PHASES, 2), 30, ["jewel: 4 shots, not 3"]), 3)
    assert text.count("2 files were whole") == len(PHASES)
    assert "| wrong | jewel: 4 shots, not 3 |" in text
    assert "| wrong | nothing |" in page(Found(), 3)
