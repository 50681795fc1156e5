"""From a motion and its observation to the minimum, its covariance and the published parameters.

constraints: What a model knows of its parameters before the fit: values held fixed, priors, bounds.
gauss_newton: Least squares on moments: one pass over the samples gives residual, gradient and normal matrix
    exactly.
multiple_minima: Several minima that explain a record about equally well.
noise_weighting: Last steps of a fit in coloured noise: every harmonic weighted by the noise that stands there.
normal_equations: Normal equations from moments, compiled: the fit calls this once a pass, and arrays of twelve are
    all overhead.
nuisance: Steady tones and drift fitted together with the ring-down, in linear least squares over all samples.
observation_model: How the motion becomes channels: objects that give the gains of the kernel's two functions f1,
    f2.
problem: What a fit minimises: chi^2 of a record under a model, its normal equations, and the minimum it leads to.
progressive: The stages of a fit: Gauss-Newton on growing windows, from a few periods to the whole.
public_parameters: From the fit's smooth internal parameters to the published ones, with the exact Jacobian.
"""
