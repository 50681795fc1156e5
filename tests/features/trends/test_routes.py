"""Trends by REST, and the alarm of a change."""

import pytest

from platform_daemon.core.recordings.recording import StepLabel
from platform_daemon.features.alarms.board import AlarmBoard
from platform_daemon.features.trends import index_keeper as trend_keeper
from tests.kit.command_line import wait_for
from tests.kit.rest import pages, problem
from tests.kit.specimen_months import months, procedure

JEWEL = "paper jewel specimen"


def _specimens(client):
    """Names of the specimens; none as long as the index is being made (503)."""
    answer = client.get("/specimens")
    return [] if answer.status_code == 503 else answer.json()["items"]


def test_what_nobody_foresaw_in_one_recording_does_not_end_the_trends(client, monkeypatch):
    looked = []

    def looks(folder, told):
        looked.append(0)
        raise UnicodeError

    monkeypatch.setattr(trend_keeper, "update_index", looks)
    (client.folder.recordings / "x.h5").touch()
    wait_for(lambda: looked)
    monkeypatch.undo()
    wait_for(lambda: _specimens(client) == [JEWEL])


@pytest.mark.long
def test_recordings_that_appear_are_in_the_trend_and_a_change_raises_an_alarm(client):
    wait_for(lambda: _specimens(client) == [JEWEL])
    report = client.get(f"/specimens/{JEWEL}/trend").json()
    assert [point["shots"] for point in report["points"]] == [2]
    assert any("still learning" in note for note in report["notes"])
    folder = client.folder.recordings
    for path in months(folder.parent, 70):
        path.rename(folder / path.name)
    wait_for(lambda: _specimens(client) == ["T 1", JEWEL])
    name = "trend:T 1:lost_magnetisation"
    wait_for(
        lambda: name in {each["name"] for each in client.get("/alarms").json()["items"] if each["cleared"] is None}
    )
    found = client.get("/specimens/T 1/trend").json()
    assert [change["name"] for change in found["changes"]] == ["lost_magnetisation"]
    assert client.get("/specimens/T 1/trend/picture").content.startswith(b"\x89PNG")
    table = client.get("/specimens/T 1/trend/table").text.splitlines()
    assert table[0].startswith("at,recording,shots,temperature_c,f_nat_hz,f_nat_hz_corrected")
    assert len(table) == 71
    assert [page["items"] for page in pages(client, "/specimens", 1)] == [["T 1"], [JEWEL]]
    listed = [page["items"] for page in pages(client, "/recordings?specimen=T 1&limit=30&until=2026-03-16")]
    assert [len(page) for page in listed] == [30, 30, 4]
    assert client.get("/recordings", params={"specimen": "T 1", "refused": True}).json()["items"] == []
    assert client.get("/recordings", params={"sample": "T 1", "verdict": "refused"}).json()["items"] == []
    assert len(client.get("/recordings?verdict=good&sample=T 1&until=2026-03-01").json()["items"]) == 4
    (listed,) = client.get("/recordings", params={"resonator": JEWEL}).json()["items"]
    assert (listed["sample"], listed["resonator"]) == (JEWEL, JEWEL)
    assert listed["good"] + listed["refused"] == listed["frames"]
    assert (listed["f_nat_hz"], listed["m_r_am2"]) == pytest.approx((213.17, 0.01202), rel=1e-3)
    problem(client.get("/recordings?sample=T 1&specimen=T 2"), 422)
    problem(client.get("/recordings?refused=true&verdict=good"), 422)
    problem(client.get("/recordings?since=x"), 422)
    body = {"by": "DC", "reason": "new magnet", "since": "2026-03-13T12:00:00Z"}
    assert client.post("/specimens/T 1/baseline", json=body).json()["by"] == "DC"
    assert name in {each["name"] for each in client.get("/alarms").json()["items"] if each["cleared"] is not None}
    assert client.get("/specimens/T 1/trend").json()["changes"] == []
    kept = [client.get("/specimens/T 1/trend?newest=1000").json() for _ in range(2)]  # the second is not made again
    assert kept[0] == kept[1] == client.get("/specimens/T 1/trend").json()
    assert client.get("/specimens/T 1/trend?newest=2").json()["points"] == kept[0]["points"][-2:]
    problem(client.get("/specimens/T 1/trend?newest=0"), 422)
    problem(client.post("/specimens/nobody/baseline", json=body), 404)
    problem(client.post("/specimens/T 1/baseline", json={"by": " ", "reason": "x"}), 422)
    (folder / ".baselines.json").unlink()
    (folder / "T-1-069.h5").unlink()  # so that it is looked at again, and found changed as before
    wait_for(
        lambda: name in {each["name"] for each in client.get("/alarms").json()["items"] if each["cleared"] is None}
    )
    for path in folder.glob("T-1-0[5-6]*.h5"):
        path.unlink()
    wait_for(
        lambda: name in {each["name"] for each in client.get("/alarms").json()["items"] if each["cleared"] is not None}
    )


def test_a_page_says_what_is_known_of_a_specimen(client):
    wait_for(lambda: JEWEL in _specimens(client))
    page = client.get(f"/specimens/{JEWEL}").json()
    assert (page["specimen"], page["recordings"], page["shots"]) == (JEWEL, 1, 2)
    resonator = page["resonators"][0]
    assert (resonator["key"], resonator["variant"], resonator["recordings"]) == ("jewel", "jewel", 1)
    assert resonator["sequence"]["f_tx_hz"] > 200
    assert sum(page["calibrations"].values()) == 1
    assert page["models"] == page["changes"] == page["tags"] == []
    for link in page["links"].values():
        assert client.get(link).status_code == 200


def test_a_trend_is_of_the_step_of_procedures_that_is_named(client):
    labels = [StepLabel(1, {}, "tune"), StepLabel(2, {}, "series")]
    procedure(client.folder.recordings, "whole", labels, [209.0, 213.0])
    wait_for(lambda: "T 1" in _specimens(client))

    def f_nat(**query):
        report = client.get("/specimens/T 1/trend", params=query).json()
        return next(chart["value"] for chart in report["charts"] if chart["quantity"] == "f_nat_hz")

    assert f_nat() == [213.0]
    assert f_nat(step="tune") == f_nat(step="1") == [209.0]
    rows = client.get("/specimens/T 1/trend/table", params={"step": "tune"}).text.splitlines()
    assert rows[1].split(",")[4] == "209.0"
    drawn = {client.get("/specimens/T 1/trend/picture", params=query).content for query in ({}, {"step": "tune"})}
    assert len(drawn) == 2
    for part in ("", "/table", "/picture"):
        for step, said in (("sweep", "no procedure of this specimen has a step"), ("all", "takes one step")):
            refused = problem(client.get(f"/specimens/T 1/trend{part}", params={"step": step}), 422)
            assert said in refused["detail"]
    problem(client.get("/specimens/T 1/trend?step="), 422)


def test_recordings_are_found_by_tag(client):
    folder = client.folder.recordings
    wait_for(lambda: JEWEL in _specimens(client))
    for path in months(folder.parent, 2, "tagged", comment="warm day #Night, (#run.7). And # no tag"):
        path.rename(folder / path.name)
    wait_for(lambda: len(client.get("/recordings?tag=night").json()["items"]) == 2)
    assert len(client.get("/recordings", params={"tag": "#NIGHT"}).json()["items"]) == 2
    assert client.get("/recordings?tag=day").json()["items"] == []
    assert client.get("/specimens/tagged").json()["tags"] == ["night", "run.7"]
    assert client.get("/specimens/tagged").json()["resonators"][0]["key"] is None


def test_bad_input(client):
    wait_for(lambda: JEWEL in _specimens(client))
    problem(client.get("/specimens/nobody"), 404)
    assert "no recording is of 'nobody'" in problem(client.get("/specimens/nobody/trend"), 404)["detail"]
    problem(client.get(f"/specimens/{JEWEL}/trend?since=x"), 422)
    for end in ("since=0001-01-01T00:00:00%2B01:00", "until=9999-12-31T23:59:59-01:00"):
        for path in ("/recordings", f"/specimens/{JEWEL}/trend"):
            assert "no time of ISO 8601" in problem(client.get(f"{path}?{end}"), 422)["detail"]
    turned = "since=2026-11-26&until=2026-11-25"
    for path in ("/recordings", f"/specimens/{JEWEL}/trend", f"/specimens/{JEWEL}/trend/table"):
        assert "2026-11-25 is before 2026-11-26" in problem(client.get(f"{path}?{turned}"), 422)["detail"]
    assert client.get("/recordings?since=2026-11-25&until=2026-11-25").status_code == 200
    problem(client.get(f"/specimens/{JEWEL}/trend?points_to_false_alarm=1"), 422)


def test_a_recording_is_found_as_soon_as_it_is_there(client):
    wait_for(lambda: JEWEL in _specimens(client))
    for n, path in enumerate(months(client.folder.recordings.parent, 4, "at once")):
        path.rename(client.folder.recordings / path.name)
        assert len(client.get("/recordings?sample=at once").json()["items"]) == n + 1
    assert client.get("/specimens/at once").json()["recordings"] == 4


def test_a_name_may_hold_a_slash(client):
    folder = client.folder.recordings
    for path in months(folder.parent, 2, "A7/left?"):
        path.rename(folder / path.name.replace("/", "-"))
    wait_for(lambda: client.get("/specimens/A7%2Fleft%3F").json().get("recordings") == 2)
    page = client.get("/specimens/A7%2Fleft%3F").json()
    assert page["specimen"] == "A7/left?"
    for link in page["links"].values():
        assert client.get(link).status_code == 200
    client.app.state.context.part(AlarmBoard).notice("trend:A7/left?:wear", "x")
    told = client.post("/alarms/trend:A7%2Fleft%3F:wear/acknowledge", json={"by": "DC"})
    assert told.json()["acknowledged_by"] == "DC"


def stands(client, name):
    return any(each["name"] == name and each["cleared"] is None for each in client.get("/alarms").json()["items"])


def test_an_alarm_ends_with_its_own_specimen_and_no_other(client):
    folder, context = client.folder.recordings, client.app.state.context
    paths = months(folder.parent, 1, "K") + months(folder.parent, 1, "K:2")
    moved = [path.rename(folder / path.name) for path in paths]
    wait_for(lambda: {"K", "K:2"} <= set(client.get("/specimens").json()["items"]))
    for name in ("trend:K:wear", "trend:K:2:wear"):
        context.part(AlarmBoard).notice(name, "x")
    context.part(trend_keeper.TrendKeeper).judge("K")
    assert (stands(client, "trend:K:wear"), stands(client, "trend:K:2:wear")) == (False, True)
    moved[1].unlink()  # archived
    wait_for(lambda: not stands(client, "trend:K:2:wear"))
    moved[0].unlink()
