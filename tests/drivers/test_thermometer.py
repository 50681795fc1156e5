"""A thermometer is looked at: what fails there is an error of the reading and of nothing else."""

from __future__ import annotations

import pytest

from drivers.errors import DeviceError, DeviceNotFound, DeviceProtocolError, DeviceTimeout
from drivers.thermometer import RetriedThermometer, plausible_temperature_c


class Scripted:
    """Answers one after the other; an error is raised."""

    def __init__(self, *answers):
        self.answers, self.closed = list(answers), False

    def temperature_c(self):
        answer = self.answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    def close(self):
        self.closed = True


@pytest.mark.parametrize("reading", [-999.0, -127.0, 85.0, 1e38, 9.91e37, float("nan"), float("inf"), -273.15])
def test_a_number_that_stands_for_no_probe_is_no_temperature(reading):
    with pytest.raises(DeviceProtocolError, match="no temperature"):
        plausible_temperature_c(Scripted(reading))


@pytest.mark.parametrize("reading", [-40.0, 0.0, 22.5, 80.0])
def test_a_temperature_is_one(reading):
    assert plausible_temperature_c(Scripted(reading)) == reading


def test_one_that_is_missing_at_first_is_opened_later_and_not_asked_all_the_time():
    now_s, tries, there = [0.0], [], []

    def open_it():
        tries.append(now_s[0])
        if not there:
            raise DeviceNotFound("nothing answers")
        return Scripted(21.0, DeviceTimeout("no answer"), 22.0)

    thermometer = RetriedThermometer(open_it, lambda: now_s[0])
    for _ in range(3):
        with pytest.raises(DeviceNotFound):
            thermometer.temperature_c()
    assert tries == [0.0]
    there.append(True)
    now_s[0] = 11.0
    assert thermometer.temperature_c() == 21.0
    with pytest.raises(DeviceTimeout):
        thermometer.temperature_c()
    with pytest.raises(DeviceTimeout):  # the same again: a question costs its time-out
        thermometer.temperature_c()
    now_s[0] = 22.0
    assert thermometer.temperature_c() == 22.0
    assert tries == [0.0, 11.0]
    thermometer.close()
    with pytest.raises(DeviceError):
        thermometer.temperature_c()


def test_an_answer_without_sense_does_not_delay_the_next_question():
    thermometer = RetriedThermometer(lambda: Scripted(DeviceProtocolError("makes no sense"), 22.0), lambda: 0.0)
    with pytest.raises(DeviceProtocolError):
        thermometer.temperature_c()
    assert thermometer.temperature_c() == 22.0
