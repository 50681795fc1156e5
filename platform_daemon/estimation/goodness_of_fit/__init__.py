"""What a fit leaves over, and what follows: warnings, other models, refusals, the verdict.

acceptance: When a converged fit is still not to be believed.
block_residual: From a fitted state to its residual: block means of samples and motion, and the floor of an angle's
    noise.
collinearity: Doubts about fitted losses: sources of energy, losses that are not there, losses that cannot be told
    apart.
compression: A receiver that compresses: its output falls behind the motion with odd powers of it, the same at every
    time.
damped_sinusoid: A decaying oscillation in what a fit leaves over, with the frequency and decay that explain most of
    it.
envelope_lack_of_fit: Does the residual hold what a wrong loss leaves: a slow misfit of amplitude or phase, far
    below the noise's power?.
failure_cause: Why no fit got through: another variant would, the receiver compresses, there are two resonators,
    much is left.
flat_tops: Flat tops under noise that was added after them, told from what else a fit can leave over.
held_losses: Losses that are held at a known value, but only where the window cannot tell them from the others.
interference: From a converged fit to one that is joint with the steady tones and the drift that its residual shows,
    if any.
lack_of_fit: What the residual says: refusals and warnings about a fit that leaves more than noise.
mirror_ambiguity: Do the data say which of a motion's two twins is published?.
model_comparison: Does another declared model explain a record better, and are the numbers of the asked one wrong
    for it?.
noise_floor: What the residual of an angle tells of its own noise: the level above the motion's harmonics, and what
    is below.
omitted_component: How far a fit would move if a second oscillation were fitted with it, in linear approximation.
residual: What a fit leaves over: its residual as block means in units of the noise, how white it is, and where it
    stands out.
residual_jacobian: A residual together with what the fit could still move: the material of tests for what a model
    lacks.
second_oscillation: A second resonator in the same record, told from what else a fit can leave over.
thresholds: From where on a fit is doubted or refused: every threshold of the judgement, in one place.
verdict: The verdict on a minimum: quality figures, warnings, published parameters, or a refusal.
"""
