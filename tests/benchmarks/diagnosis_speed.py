"""How long the diagnosis of 12 thread shots of 5 s takes:  python -m tests.benchmarks.diagnosis_speed"""

from platform_daemon.diagnosis.diagnose import diagnose_shots
from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.estimation.physics.models import THREAD
from tests.kit.undeclared_shots import shots_with


def main() -> None:
    """Make them with a quadratic drag, diagnose them twice: the second time everything is compiled."""
    shots, _ = shots_with("thread", [{"id": "quadratic_drag", "strength": 1e-5}], count=12, rx_s=5.0, seed=5)
    for _ in range(2):
        report = diagnosis_report(diagnose_shots(shots, THREAD)).model_dump(mode="json")
        print(f"{report['seconds']:.0f} s, {report['verdict']}: {report['effects']}; {report['held_out']}")


if __name__ == "__main__":
    main()
