"""One shot of tune: how it was made, and what it tells of the resonator."""

from __future__ import annotations

from dataclasses import dataclass

from platform_daemon.core.schemas.fits import ParameterEstimate
from platform_daemon.estimation.refusal import Refusal
from platform_daemon.features.procedures.schema import RingingLine, StepReport

from . import numbers

SURE_HZ = 0.1
SURE_SWING = 0.05


@dataclass(frozen=True)
class TuneShot:
    """A burst of so many periods at f_tx_hz in a field, T, near_hz where the search began, and its report."""

    f_tx_hz: float
    periods: int
    field_t: float
    near_hz: float
    report: StepReport

    def value(self, name: str) -> float:
        """A result of its fit."""
        return self.report.results[name].median

    def estimate(self, name: str) -> ParameterEstimate | None:
        """A result of its fit with its standard deviation; None: the fit has none of that name."""
        found = self.report.results.get(name)
        return None if found is None else ParameterEstimate(value=found.median, std=found.std)

    @property
    def fitted(self) -> bool:
        """A fit found an oscillation near where the search began: no side mode, nothing else in the room."""
        from platform_daemon.features.procedures.ringing import RINGING_SPAN

        return "f_nat_hz" in self.report.results and (
            1 / RINGING_SPAN < self.value("f_nat_hz") / self.near_hz < RINGING_SPAN
        )

    @property
    def heard(self) -> RingingLine | None:
        """The line that rings, fitted or not."""
        return self.report.heard

    @property
    def rings(self) -> bool:
        """Something rings near where the search began."""
        return self.fitted or self.heard is not None

    @property
    def saturated(self) -> bool:
        """The fit was refused because the receiver was saturated."""
        return (self.report.reason or "").startswith(Refusal.SATURATED.name.lower())

    @property
    def sure(self) -> bool:
        """The fit knows f_nat to 0.1 Hz and the swing to 5 %."""
        if not self.fitted:
            return False
        f_nat, swing = self.report.results["f_nat_hz"].std, self.report.results["phi_max_rad"].std
        return f_nat is not None and swing is not None and f_nat <= SURE_HZ and swing <= SURE_SWING * self.swing_rad

    @property
    def f_nat_hz(self) -> float:
        """By the fit, else the frequency of the line that rings, else that at which the shot was made."""
        if self.fitted:
            return self.value("f_nat_hz")
        return self.f_tx_hz if self.heard is None else self.heard.frequency_hz

    @property
    def swing_rad(self) -> float:
        """Swing at the first RX sample, by the fit."""
        return self.value("phi_max_rad")

    @property
    def effect(self) -> float:
        """Effect of the burst as a share of that at f_nat."""
        return numbers.effect_beside(self.periods, self.f_tx_hz, self.f_nat_hz)

    def measured(self) -> numbers.Measured:
        """The resonator by the fit."""
        f_nat_hz = self.value("f_nat_hz")
        # Where there is hardly any of them, noise makes them negative.
        tf_over_i = (
            max(0.0, self.value("tf_over_i_rad_per_s2")) if "tf_over_i_rad_per_s2" in self.report.results else 0.0
        )
        driven = self.swing_rad + numbers.friction_loss_rad(tf_over_i, f_nat_hz, self.periods)
        return numbers.Measured(
            f_nat_hz=f_nat_hz,
            lambda_per_s=max(0.0, self.value("lambda_per_s")),
            tf_over_i=tf_over_i,
            swing_rad_per_t=driven / max(self.effect, 0.1) / (self.field_t * self.periods),
            noise_rad=self.swing_rad / max(self.heard.snr if self.heard is not None else 1.0, 1.0),
        )
