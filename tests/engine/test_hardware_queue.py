"""What waits, and what of it will begin by itself."""

from platform_daemon.engine.hardware_queue import HardwareQueue
from platform_daemon.engine.jobs import Job


def test_a_job_that_was_paused_before_it_began_holds_nobody_up():
    queue, job = HardwareQueue(), Job("acquisition", None, None, 1, "shots")
    assert not queue.awaits
    queue.put(job, lambda job: None)
    assert queue.awaits
    job.pause_requested.set()
    assert not queue.awaits
    assert queue.take(0.0) is None
    job.cancel_requested.set()  # it is taken, so that it ends
    assert queue.awaits
