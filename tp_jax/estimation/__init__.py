"""Estimation: recordings in windows, fitted by least squares with the window states eliminated.

layout, program, windows, problem    what is estimated, and its one compiled linearisation
                                     (linearisation, placement, program_choice, two_threads)
prepared_campaign                    noise, layout, window lengths, priors: what fits begin with
start, period, schedule, sharpen     a start from the data, the schedule of all fits: growing
                                     windows, sharper friction (slow_contact)
weak_form                            a better start: no derivatives of the data (modulating,
                                     compensated)
priors, fitted                       what is known beforehand; where a fit ended
elimination, normal_equations        window states eliminated; what is left is one small quadratic,
                                     and all that is asked of it: steps, covariances, projections
variable_projection                  the one fit: its steps (coordinates, bounded_step), the
                                     windows' states (window_states), robust losses (robust)
projected_gauss_newton               variable projection as a solver of optimistix
optimistix_methods                   that, Levenberg-Marquardt, Dogleg, BFGS, or a solver of the
                                     user's own, on one traced function (window_residuals)
drive_errors                         noisy measured drives as the angles show them
blocks, intervals, noise_levels      scatter of blocks, intervals, noise by channel
free_runs                            the paper's objective (17), of many sets of numbers at once
simplex, nelder_mead                 the paper's method, for optimistix, from one simplex or many;
                                     free_run_search: on (17)
starts, multistart                   from where, who met whom (optima, outcome)
success, checkpoint, kept_fits       how often it works and what it costs; going on after Ctrl-C
assemble                             a pendulum from the numbers of a fit
methods, identify, identification    all of it for a user
"""
