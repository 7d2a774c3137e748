/* arrays.h: the arrays of an instance, in the order in which they lie in its memory, with their sizes.
 *
 * ARRAY(type, name, count) is one of an instance; NUMBERS(name, count) is one of doubles of an instance
 * and one of lanes of a batch. The files that include this one define both, to declare the arrays
 * (instance.h, lanes/batch.h) or to place them (layout.c, lanes/batch.c), and SCRATCH, where the arrays
 * end that are saved. `n`, `unknown` and the like are the numbers of layout.c. There is no include guard.
 */

/* --- saved: parameters, states and inputs */
ARRAY(double, p, (size_t)m->n_param + (size_t)c->n_selector)
NUMBERS(h, (size_t)m->n_hoist)
NUMBERS(x, n)
NUMBERS(u, (size_t)m->n_input + switches)
NUMBERS(u_step, (size_t)m->n_input + switches) /* inputs and modes of the last step */

/* --- switches, sampled parts and jumps */
ARRAY(double, mode, switches)      /* modes at the present; NaN where a switch has none */
ARRAY(double, argument, switches)  /* arguments at the present */
NUMBERS(extent, switches)          /* the largest absolute value of each argument so far */
ARRAY(double, swing, switches)     /* the variation of each argument over a step (switch_margins.c) */
/* How far from its edge the argument of a kink at rest there may be by rounding; 0 where it does not rest
 * (switch_margins.c). */
ARRAY(double, rest, switches)
/* Consecutive immediate returns to the mode before; INFINITY: the switch is left to error control. */
ARRAY(double, returns, switches)
ARRAY(double, change_of_mode, switches) /* the last change of each mode */
ARRAY(double, sampling, 2 * (size_t)m->n_rate) /* periods and offsets */
ARRAY(double, instants, (size_t)m->n_rate)     /* instants that have passed */
/* Not 0 where the mode is that before a jump: how far the argument may lie beyond its edge by rounding
 * (jumps.c). */
ARRAY(double, turned, m->n_jump > 0 ? switches : 0)
ARRAY(double, holds, (size_t)m->n_jump)       /* not 0 where the condition was true at the last event */
ARRAY(double, jumped_at, (size_t)m->n_jump)   /* time of the last jump, */
ARRAY(double, close_jumps, (size_t)m->n_jump) /* and jumps in quick succession */

/* --- states below their tolerances (subtolerance.c), and divisors */
ARRAY(double, subtol_phase, n)
NUMBERS(subtol_from, n)
NUMBERS(subtol_to, n)
ARRAY(double, subtol_low, n)
ARRAY(double, subtol_at, n)
ARRAY(double, subtol_entered, n)
ARRAY(double, subtol_left, n)
ARRAY(bgc_subtolerance_state, subtol, n)
ARRAY(double, divisor_extent, (size_t)m->n_divisor) /* the largest absolute value of each so far */
ARRAY(double, divisor_slope, (size_t)m->n_divisor)  /* the rate of each at the end of the last step */

/* --- the mass matrix with its scales, and ranges of terms of time */
ARRAY(double, u_seen, (size_t)m->n_input)
NUMBERS(scale, unknown)
NUMBERS(mass, (size_t)m->n_mass)
ARRAY(bgc_range, h_range, bgc_has_ranges(m) ? (size_t)m->n_hoist : 0) /* h and u as ranges: ranges.c */
ARRAY(bgc_range, u_range, bgc_has_ranges(m) ? (size_t)m->n_input + switches : 0)
ARRAY(double, variation, (size_t)m->n_term) /* of each term, the largest that a step resolved */
ARRAY(double, patience, (size_t)m->n_term)  /* factor of the steps that each allows; INFINITY: not watched */
ARRAY(double, f_before, m->n_term > 0 ? n : 0) /* f at the start of a step that a term has limited */
NUMBERS(inverse_mass, n)    /* 1 / m_ii where row i of M has no other entry, else 0 */
ARRAY(double, algebraic, n) /* 1 where row i of M is empty, else 0 */

/* --- df/dx, the factors of W, and what estimates keep from step to step */
NUMBERS(jac, local > slopes ? local : slopes)
NUMBERS(dfdt, n)
NUMBERS(lu, (size_t)m->n_lu)
NUMBERS(f, n)
NUMBERS(correction, n) /* of fixed steps: corrections.c */
NUMBERS(corrected_at, n)
NUMBERS(range, n)
ARRAY(double, dominant, n) /* of the last power iteration: stiffness.c */
NUMBERS(direction, n)      /* of the power iteration of spectrum.c, */
NUMBERS(image, n)          /* and its image */

/* --- the ends of the last step, its dense output, and the rows of closed chains */
ARRAY(double, y0, n)
ARRAY(double, y1, n)
NUMBERS(k, BGC_MAX_DENSE * bgc_chunked(m->n_state)) /* dense output */
ARRAY(bgc_complex, lu_complex, (size_t)m->n_lu)
ARRAY(double, closed_before, responses) /* dw/dx and responses of closed chains at the present */
ARRAY(double, response_size, (size_t)c->n_row) /* of each row: the largest diagonal of S so far */
ARRAY(double, chosen, choices) /* 1 where a row or condition of these is chosen, else 0 */
ARRAY(double, off, n) /* how far the present is off, true minus computed: global_error.c, */
ARRAY(double, off_before, n) /* and the ends of the last step, before a jump */
ARRAY(double, off_at_end, n)
/* The same of the dense output at three points, beside that of the ends. */
ARRAY(double, off_inside, 3 * bgc_padded(m->n_state))
ARRAY(double, off_local, n) /* the local error of the last measured step: local_error.c */
ARRAY(double, largest_off, (size_t)m->n_output) /* the largest errors since the last row, */
ARRAY(double, last_off, (size_t)m->n_output)    /* the last ones, */
ARRAY(double, lowest, (size_t)m->n_output)      /* and the ends of the ranges of the outputs so far */
ARRAY(double, highest, (size_t)m->n_output)
SCRATCH

/* --- scratch: the stages and right-hand sides of a step */
NUMBERS(stages, BGC_MAX_STAGES * bgc_chunked(m->n_state)) /* the U_i, or Z_i */
/* f at the stages, corrections. */
ARRAY(double, implicit, 2 * BGC_MAX_IMPLICIT * bgc_padded(m->n_state))
ARRAY(bgc_complex, complex_right, n)
ARRAY(bgc_complex, b_complex, unknown)
ARRAY(bgc_complex, residual_complex, unknown)
NUMBERS(next, n)  /* the solution of a step, */
NUMBERS(error, n) /* and its error estimate */
NUMBERS(noise, n) /* the error estimate of a perturbed attempt */
NUMBERS(f_last, n) /* f at the last stage of an explicit step */
NUMBERS(point, n)
NUMBERS(right, n)
NUMBERS(residual, unknown)
NUMBERS(magnitude, unknown)
NUMBERS(b, unknown)

/* --- results of kernels */
NUMBERS(output, (size_t)m->n_output + 4)
ARRAY(double, command, (size_t)m->n_command)
NUMBERS(check, checks)

/* --- switches, divisors, jumps, pulses and terms of time within a step */
ARRAY(double, samples, BGC_SAMPLES * bgc_padded(m->n_switch)) /* arguments of switches */
ARRAY(double, divisors, (BGC_SAMPLES + 1) * bgc_padded(m->n_divisor))
ARRAY(double, probe, switches) /* arguments of switches */
ARRAY(double, after, switches)
ARRAY(double, ignored, switches) /* not 0 where a change is negligible in the step under way */
ARRAY(double, held_value, (size_t)m->n_held)
ARRAY(double, condition, (size_t)m->n_jump)
ARRAY(double, reset_value, resets)
ARRAY(double, edge_rate, (size_t)m->n_edge) /* rates of the arguments of the switches of conditions */
ARRAY(double, moved, (size_t)m->n_edge) /* not 0 where motion, not a jump, has changed the mode */
ARRAY(double, watch_sample, (BGC_SAMPLES + 1) * (size_t)m->n_watch) /* watched arguments */
ARRAY(double, watch_probe, (size_t)m->n_watch)
ARRAY(bgc_range, term_range, 2 * (size_t)m->n_term) /* of each term and its derivative by time */
/* Of each argument of a switch of time alone, and its derivative. */
ARRAY(bgc_range, timed_range, m->timed_ranges != NULL ? 2 * (size_t)m->n_timed : 0)
ARRAY(double, around, (size_t)m->n_term) /* variations to compare with, */
ARRAY(double, widest, (size_t)m->n_term) /* and in the window ahead */

/* --- errors of the states: global_error.c */
ARRAY(double, off_work, 12 * bgc_padded(m->n_state))
ARRAY(double, off_output, (size_t)m->n_output) /* outputs of the true state */
ARRAY(double, off_reset, resets)
ARRAY(double, off_argument, switches) /* arguments at an event, and their derivatives */
ARRAY(double, off_along, switches)
ARRAY(double, off_rate, switches)

/* --- Newton's method for consistent values: consistent.c */
ARRAY(double, first, n)
ARRAY(double, start, n)
ARRAY(double, largest, n)
NUMBERS(trial, n)
ARRAY(double, homotopy, n)
NUMBERS(change, n)
ARRAY(double, next_change, n)

/* --- scratch of kernels and of linear algebra, with inner unknowns */
ARRAY(double, block_jac, (size_t)m->n_jac)
NUMBERS(work, kernel_work)
ARRAY(double, sparse_work, 3 * unknown) /* elimination by tables, */
ARRAY(double, block_work, m->blocks == NULL ? 0 : 18 * (size_t)m->blocks->n_place) /* and in blocks */
NUMBERS(wide, unknown) /* a right-hand side with inner rows, and its solution */
ARRAY(bgc_complex, wide_complex, m->n_inner > 0 ? unknown : 0)
ARRAY(double, local, m->n_inner > 0 ? local : 0) /* inner.c */
ARRAY(double, slopes, m->n_inner > 0 ? slopes : 0)
NUMBERS(reach, unknown) /* sizes of a solution that count in its check */

/* --- the equations of the start: unknowns, Newton iterates, residuals and factors (start.c) */
ARRAY(double, start_at, unknowns)
ARRAY(double, start_from, unknowns)
ARRAY(double, start_trial, unknowns)
ARRAY(double, start_change, unknowns)
ARRAY(double, start_next, unknowns)
ARRAY(double, start_first, unknowns)
ARRAY(double, start_magnitude, unknowns)
ARRAY(double, start_jac, unknowns * unknowns)
ARRAY(double, start_lu, unknowns * unknowns)

/* --- closed chains: closures.c */
ARRAY(double, closing, bgc_closing_size(m))
ARRAY(double, closed_after, responses) /* as closed_before, at the end of the step, */
ARRAY(double, next_chosen, choices)    /* and as chosen from there on */
