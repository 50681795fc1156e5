"""From recordings to shots that a joint fit can begin with.

initial_fits: From shots to fits of the declared model that later steps begin at, whatever the fit thinks of its
    residual.
linearisation: The local linear picture of one shot: what is left of the data at a state, and how it moves with
    every parameter.
shot: One shot as the diagnosis takes it, and the grid of instants at which it is looked at.
thread_pool: Threads over shots: the numerical libraries are kept from starting threads of their own, which would
    only wait.
"""
