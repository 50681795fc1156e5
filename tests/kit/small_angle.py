"""The equivalent quality factor in closed form, where angles are small: what the traced motion is held against."""

import math

from platform_daemon.estimation.physics.quality import quality_factor


def small_angle_quality_factor(f_nat_hz, lambda_per_s, tf_over_i_rad_per_s2, amplitude_rad):
    """tilde Q for T to infinity in closed form, for small angles and constant friction (eq:Jewel_ODE_norm_simp).

    Averaged over a period the amplitude obeys dA/dt = -lambda A - c with c = 2 (T_f/I) / (pi omega_nat), because
    friction takes 4 T_f A per cycle. So A = (A_0 + c/lambda) exp(-lambda t) - c/lambda until it ends at
    t = ln(1 + x)/lambda, x = lambda A_0 / c; the area under it, over A_0, gives
        tilde Q = omega_nat/(2 lambda) (1 - ln(1 + x)/x)   ->   pi A_0 omega_nat^2 / (8 T_f/I)   for lambda -> 0.
    Validity: signal proportional to the angle, friction not weakened by cos^(4/3), and A_0 well above the angle
    (T_f/I)/omega_nat^2 at which friction holds the rotor. For the paper's jewel, which sticks at 0.04 degrees, it
    deviates from the exact value by +0.3 % at 1 degree, -0.1 % at 5, -1.2 % at 23, -5.8 % at 53. A_0: the real peak.
    """
    if tf_over_i_rad_per_s2 == 0.0:
        return quality_factor(f_nat_hz, lambda_per_s)
    w = 2.0 * math.pi * f_nat_hz
    x = 0.5 * math.pi * w * lambda_per_s * amplitude_rad / tf_over_i_rad_per_s2
    # (x - ln(1 + x)) / x^2, by its series where the difference cancels.
    share = 0.5 - x / 3.0 + x * x / 4.0 if abs(x) < 1e-4 else (x - math.log1p(x)) / (x * x)
    return 0.25 * math.pi * w * w * amplitude_rad / tf_over_i_rad_per_s2 * share
