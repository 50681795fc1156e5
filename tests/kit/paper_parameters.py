"""Mean parameters of the paper's four datasets (tab:model_params_fit_result); w along z, v along x."""

import math

ALONG_X = {"rodrigues_x": 0.0, "rodrigues_y": 0.0, "rodrigues_z": -math.pi / 2}


def values(f_nat_hz, m_r_am2, lambda_per_s, friction, phi_max_deg, psi_deg):
    public = {
        "f_nat_hz": f_nat_hz,
        "m_r_am2": m_r_am2,
        "lambda_per_s": lambda_per_s,
        "phi_max_rad": math.radians(phi_max_deg),
        "psi_start_rad": math.radians(psi_deg),
        **ALONG_X,
    }
    return public if friction is None else {**public, "tf_over_i_rad_per_s2": friction}


JEWEL_N50 = values(212.93, 12.262e-3, 0.2465, 1063.0, 52.4, 219.1)
JEWEL_D30 = values(213.25, 12.028e-3, 0.0978, 1324.0, 53.0, 219.2)
THREAD_N50 = values(215.53, 11.647e-3, 0.2466, None, 21.8, 333.7)
THREAD_D30 = values(215.69, 11.014e-3, 0.2465, None, 22.8, 335.7)
N50_S, JEWEL_D30_S, THREAD_D30_S = 0.24, 1.28, 4.90
