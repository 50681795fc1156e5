"""The paper's four data sets, to be drawn by the independent generator: variant, truth, window in s."""

from tests.kit.ring_down_generator import Truth

JEWEL = Truth(f_nat_hz=213.25, m_r_am2=0.01226, tf_over_i_rad_per_s2=1190.0, phi_max_rad=0.93, psi_start_rad=3.86)
DATASETS = {
    "JN50": ("jewel", JEWEL, 0.24),
    "JD30": ("jewel", JEWEL, 1.28),
    "TN50": ("thread", Truth(), 0.24),
    "TD30": ("thread", Truth(), 4.90),
}
