/* tableaus.c: the integration methods: their coefficients, in the variables of bgc_internal.h, and
 * at the end of the file the tables of families and methods.
 *
 * Where the publication of a Rosenbrock method gives (alpha, Gamma, b), a = alpha Gamma^-1,
 * c = diag(1/gamma) - Gamma^-1, m = b Gamma^-1. tests/unit/test_numerics_tableaus.py checks every
 * order condition.
 */
#include "bgc_internal.h"

/* Order 5(4), 8 stages, stiffly accurate, L-stable, index 1; dense output of order 4.
 * Coefficients: G. Steinebach, Construction of Rosenbrock-Wanner method Rodas5P and numerical
 * benchmarks within the Julia Differential Equations package, BIT 63:27 (2023). Error weights:
 * those of Rodas5Pe, G. Steinebach, Rosenbrock methods within OrdinaryDiffEq.jl (2024). */
static const bgc_tableau rodas5p = {
    .stages = 8,
    .w_order = 1,
    .dense = 3,
    .gamma = 0.21193756319429014,
    .a = {
        {0.0},
        {3.0},
        {2.849394379747939, 0.45842242204463923},
        {-6.954028509809101, 2.489845061869568, -10.358996098473584},
        {2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641},
        {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256,
         0.030198172008377946},
        {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256,
         0.030198172008377946, 1.0},
        {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256,
         0.030198172008377946, 1.0, 1.0}
    },
    .c = {
        {0.0},
        {-14.155112264123755},
        {-17.97296035885952, -2.859693295451294},
        {147.12150275711716, -1.41221402718213, 71.68940251302358},
        {165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306},
        {24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125,
         -0.6610691825249471},
        {30.91273214028599, -3.1208243349937974, 77.79954646070892, 34.28646028294783,
         -19.097331116725623, -28.087943162872662},
        {37.80277123390563, -3.2571969029072276, 112.26918849496327, 66.9347231244047,
         -40.06618937091002, -54.66780262877968, -9.48861652309627}
    },
    .m = {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256,
          0.030198172008377946, 1.0, 1.0, 1.0},
    .alpha = {0.0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664,
          1.0, 1.0, 1.0},
    .g = {0.21193756319429014, -0.42387512638858027, -0.3384627126235924, 1.8046452872882734,
          2.325825639765069},
    .e = {0.2606326497975715, -0.005158627295444251, 1.3038988631109731, 1.235000722062074,
          -0.7931985603795049, -1.005448461135913, -0.18044626132120234, 0.17051519239113755},
    .h = {
        {25.948786856663858, -2.5579724845846235, 10.433815404888879, -2.3679251022685204,
         0.524948541321073, 1.1241088310450404, 0.4272876194431874, -0.17202221070155493},
        {-9.91568850695171, -0.9689944594115154, 3.0438037242978453, -24.495224566215796,
         20.176138334709044, 15.98066361424651, -6.789040303419874, -6.710236069923372},
        {11.419903575922262, 2.8879645146136994, 72.92137995996029, 80.12511834622643,
         -52.072871366152654, -59.78993625266729, -0.15582684282751913, 4.883087185713722}
    },
};

/* Order 4(3), 6 stages, stiffly accurate, L-stable, index 1; order 2 with an inexact Jacobian;
 * dense output of order 3. G. Steinebach, Improvement of Rosenbrock-Wanner method RODASP, in:
 * Progress in Differential-Algebraic Equations II (2020). */
static const bgc_tableau rodas4p2 = {
    .stages = 6,
    .w_order = 2,
    .dense = 2,
    .gamma = 0.25,
    .a = {
        {0.0},
        {3.0},
        {0.906377755268814, -0.189707390391685},
        {3.758617027739064, 1.161741776019525, -0.849258085312803},
        {7.089566927282776, 4.573591406461604, -8.423496976860259, -0.959280113459775},
        {7.089566927282776, 4.573591406461604, -8.423496976860259, -0.959280113459775, 1.0}
    },
    .c = {
        {0.0},
        {-12.0},
        {-6.354581592719008, 0.338972550544623},
        {-8.575016317114033, -7.606483992117508, 12.22499765012482},
        {-5.888975457523102, -8.15739661784182, 24.805546872612922, 12.79040151279698},
        {-4.408651676063871, -6.692003137674639, 24.625568527593117, 16.627521966636085,
         -5.714285714285718}
    },
    .m = {7.089566927282776, 4.573591406461604, -8.423496976860259, -0.959280113459775, 1.0, 1.0},
    .alpha = {0.0, 0.75, 0.321448134013046, 0.519745732277726, 1.0, 1.0},
    .g = {0.25, -0.5, -0.189532918363016, 0.085612108792769},
    .e = {0.0, 0.0, 0.0, 0.0, 0.0, 1.0},
    .h = {
        {-5.323528268423303, -10.042123754867493, 17.175254928256965, -5.079931171878093,
         -0.016185991706112},
        {6.984505741529879, 6.914061169603662, -0.849178943070653, 18.104410789349338,
         -3.516963011559032}
    },
};

/* Order 3, 4 stages, stiffly accurate, L-stable, index 1; a W-method: order 3 with any matrix
 * in the place of the Jacobian. J. Rang, Improved traditional Rosenbrock-Wanner methods for stiff
 * ODEs and DAEs, Informatik-Bericht 2013-05, TU Braunschweig (2013). */
static const bgc_tableau ros34prw = {
    .stages = 4,
    .w_order = 3,
    .gamma = 0.435866521508459,
    .a = {
        {0.0},
        {2.0},
        {1.9166355646921893, -0.7305046154473316},
        {3.7075384385487764, 1.984721005641544, -0.7228174329072325}
    },
    .c = {
        {0.0},
        {-4.588560720558084},
        {-1.4496008611374558, 2.6585485498967283},
        {-0.8142320398640468, 2.1949369533270104, -0.9042300763629808}
    },
    .m = {3.7075384385487764, 1.9847210056415439, -0.7228174329072324, 1.0},
    .e = {0.0, 0.0, 0.0, 1.0},
    .embedded = {-0.08016142700721947, 0.15059517863671545, -0.29187352202361583,
                 0.26131506383377556},
    .alpha = {0.0, 0.871733043016918, 1.1537997822626886, 1.0},
    .g = {0.435866521508459, -0.435866521508459, -0.34459816128502135},
};

/* Order 2, 4 stages (the fifth, of the error estimate, is omitted), stiffly accurate, L-stable,
 * index 1; a W-method of order 2. G. Steinebach, Rosenbrock methods within OrdinaryDiffEq.jl
 * (2024). */
static const bgc_tableau rodas23w = {
    .stages = 4,
    .w_order = 2,
    .gamma = 0.3333333333333333,
    .a = {
        {0.0},
        {1.3333333333333333},
        {0.0},
        {2.90625, 3.375, 0.40625}
    },
    .c = {
        {0.0},
        {-4.0},
        {8.25, 6.75},
        {1.21875, -5.0625, -1.96875}
    },
    .m = {2.90625, 3.375, 0.40625, 1.0},
    .e = {0.0, 0.0, 0.0, 1.0},
    .embedded = {0.0, 0.0, 0.0, 1.0},
    .alpha = {0.0, 0.4444444444444444, 0.0, 1.0},
    .g = {0.3333333333333333, -0.1111111111111111, 1.0},
};

/* Order 2, 2 stages (the third, of the error estimate, is omitted), L-stable; a W-method of order
 * 2. L. F. Shampine, M. W. Reichelt, The MATLAB ODE suite, SIAM J. Sci. Comput. 18 (1997),
 * ode23s. */
static const bgc_tableau ros23 = {
    .stages = 2,
    .w_order = 2,
    .gamma = 0.2928932188134525,
    .a = {
        {0.0},
        {1.7071067811865475}
    },
    .c = {
        {0.0},
        {-3.414213562373095}
    },
    .m = {3.414213562373095, 3.414213562373095},
    .e = {0.0, 3.414213562373095},
    .embedded = {0.0, 3.414213562373095},
    .alpha = {0.0, 0.5},
    .g = {0.2928932188134525},
};

/* Order 1, one stage, L-stable: linearly implicit Euler. Constraints drift under it unless joints
 * close themselves. E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.9. */
static const bgc_tableau lie = {
    .stages = 1,
    .w_order = 1,
    .gamma = 1.0,
    .a = {
        {0.0}
    },
    .c = {
        {0.0}
    },
    .m = {1.0},
    .e = {0.5, -0.5}, /* the second weight is of the step before */
    .alpha = {0.0},
    .g = {1.0},
};

/* Order 4: W. Kutta, Beitrag zur naeherungsweisen Integration totaler Differentialgleichungen,
 * Z. Math. Phys. 46 (1901). */
static const bgc_tableau rk4 = {
    .stages = 4,
    .a = {
        {0.0},
        {0.5},
        {0.0, 0.5},
        {0.0, 0.0, 1.0}
    },
    .m = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0},
    .e = {0.0, -1.0 / 3.0, 1.0 / 3.0, 0.0}, /* z^3 / 12; that of `embedded` vanishes at h lambda = -4 */
    .embedded = {1.0 / 6.0, -2.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0},
    .alpha = {0.0, 0.5, 0.5, 1.0},
};

/* Order 2: K. Heun, Neue Methoden zur approximativen Integration der Differentialgleichungen einer
 * unabhaengigen Veraenderlichen, Z. Math. Phys. 45 (1900). */
static const bgc_tableau heun = {
    .stages = 2,
    .a = {
        {0.0},
        {1.0}
    },
    .m = {0.5, 0.5},
    .e = {-0.5, 0.5},
    .embedded = {-0.5, 0.5},
    .alpha = {0.0, 1.0},
};

/* Order 5(4), dense output of order 4. J. R. Dormand, P. J. Prince, A family of embedded
 * Runge-Kutta formulae, J. Comp. Appl. Math. 6 (1980); dense output: E. Hairer, S. P. Norsett,
 * G. Wanner, Solving Ordinary Differential Equations I, II.6, whose d_i are D1 to D7. */
#define D1 (-12715105075.0 / 11282082432.0)
#define D3 (87487479700.0 / 32700410799.0)
#define D4 (-10690763975.0 / 1880347072.0)
#define D5 (701980252875.0 / 199316789632.0)
#define D6 (-1453857185.0 / 822651844.0)
#define D7 (69997945.0 / 29380423.0)
static const bgc_tableau dopri5 = {
    .stages = 7,
    .dense = 3,
    .a = {
        {0.0},
        {1.0 / 5.0},
        {3.0 / 40.0, 9.0 / 40.0},
        {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0},
        {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0},
        {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0},
        {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0}
    },
    .m = {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0},
    .alpha = {0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0},
    .e = {71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0,
          -1.0 / 40.0},
    .h = {
        {1.0 - 35.0 / 384.0, 0.0, -500.0 / 1113.0, -125.0 / 192.0, 2187.0 / 6784.0, -11.0 / 84.0},
        {2.0 * 35.0 / 384.0 - 1.0 + D1, 0.0, 2.0 * 500.0 / 1113.0 + D3, 2.0 * 125.0 / 192.0 + D4,
         -2.0 * 2187.0 / 6784.0 + D5, 2.0 * 11.0 / 84.0 + D6, D7 - 1.0},
        {-D1, 0.0, -D3, -D4, -D5, -D6, -D7}
    },
};

/* Order 2, symmetric, symplectic: conserves quadratic invariants, such as the energy of linear
 * elements.
 * E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, II.1 and IV.2. */
static const bgc_collocation midpoint = {
    .stages = 1,
    .node = {0.5},
    .weight = {1.0},
    .last = {2.0},
    .e = {-2.0},
    .lambda = 2.0,
    .left = {1.0},
    .right = {1.0},
};

/* Order 4, symmetric, symplectic. The same book. */
static const bgc_collocation gauss4 = {
    .stages = 2,
    .node = {0.21132486540518712, 0.78867513459481288},
    .weight = {0.5, 0.5},
    .last = {-1.7320508075688773, 1.7320508075688773},
    .e = {-6.4641016151377546, 0.46410161513775459},
    .lambda2 = {3.0, 1.7320508075688773},
    .left2 = {{0.0, 0.5}, {1.8660254037844386, 0.0}},
    .right2 = {{0.0, 1.0}, {-0.26794919243112271, 0.0}},
};

/* Order 5(3), stiffly accurate, L-stable: Radau IIA. E. Hairer, G. Wanner, Solving Ordinary
 * Differential Equations II, IV.5 and IV.8; the eigenvectors to 17 digits from A by mpmath. */
static const bgc_collocation radau5 = {
    .stages = 3,
    .node = {0.15505102572168219, 0.64494897427831781, 1.0},
    .weight = {0.37640306270046725, 0.51248582618842162, 0.11111111111111111},
    .last = {0.0, 0.0, 1.0},
    .e = {-10.048809399827416, 1.3821427331607489, -0.33333333333333333},
    .lambda = 3.6378342527444957,
    .left = {4.1787185915519047, 0.32768282076106239, 0.52337644549944955},
    .right = {0.094438762488975241, 0.25021312296533331, 1.0},
    .lambda2 = {2.6810828736277521, 3.0504301992474106},
    .left2 = {{-2.0893592957759524, -0.16384141038053119, 0.23831177725027523},
              {-0.25143631747289344, 1.2859634749278027, -0.29801960241411246}},
    .right2 = {{-0.14125529502095421, 0.20412935229379993, 1.0},
               {0.030029194105147424, -0.38294211275726194, 0.0}},
};

/* --- families ------------------------------------------------------------------------------ */

static const bgc_family explicit_runge_kutta = {
    .name = "explicit Runge-Kutta",
    .lanes = 1,
    .rows = BGC_ROWS_LEFT,
    .advance = bgc_runge_kutta,
    .interpolate = bgc_interpolate_stages,
};

static const bgc_family rosenbrock = {
    .name = "Rosenbrock",
    .jacobian = 1,
    .lanes = 1,
    .rows = BGC_ROWS_NEARLY,
    .advance = bgc_rosenbrock,
    .interpolate = bgc_interpolate_stages,
};

/* Adaptive methods of three stages. */
static const bgc_family radau = {
    .name = "Radau IIA collocation",
    .jacobian = 1,
    .rows = BGC_ROWS_SOLVED,
    .advance = bgc_collocate,
    .interpolate = bgc_interpolate_radau,
    .correction = bgc_correction_of_slope,
    .quadrature = bgc_collocation_quadrature,
};

static const bgc_family gauss = {
    .name = "Gauss collocation",
    .jacobian = 1,
    .rows = BGC_ROWS_LEFT,
    .advance = bgc_collocate,
    .correction = bgc_correction_of_slope,
    .quadrature = bgc_collocation_quadrature,
};

/* --- methods ------------------------------------------------------------------------------- */

/* Written from compiler/language/methods.py by `pytest tests/unit/test_methods.py --bless`; families
 * above and coefficients are written by hand. The first adaptive method and the first with fixed steps
 * are the defaults. */
const bgc_method bgc_methods[] = {
    {
        .name = "rodas5p",
        .family = &rosenbrock,
        .tableau = &rodas5p,
        .order = 5,
        .error_order = 4,
        .purpose = "stiff, non-stiff and algebraic equations at medium to tight tolerances",
    },
    {
        .name = "switching",
        .family = &rosenbrock,
        .tableau = &rodas5p,
        .order = 5,
        .error_order = 4,
        .partner = "dopri5",
        .purpose = "rodas5p, and dopri5 where nothing is stiff and its steps cost less",
    },
    {
        .name = "rodas4p2",
        .family = &rosenbrock,
        .tableau = &rodas4p2,
        .order = 4,
        .error_order = 3,
        .check_dense = 1,
        .purpose = "stiff and algebraic equations at loose tolerances, 1e-3 to 1e-5",
    },
    {
        .name = "radau5",
        .family = &radau,
        .collocation = &radau5,
        .order = 5,
        .error_order = 3,
        .check_dense = 1,
        .purpose = "very stiff equations at tight tolerances; Newton iteration in each step",
    },
    {
        .name = "ros34prw",
        .family = &rosenbrock,
        .tableau = &ros34prw,
        .order = 3,
        .embedded_order = 2,
        .substeps = 8,
        .purpose = "real time: stiff and algebraic equations; keeps its order with a kept Jacobian",
    },
    {
        .name = "switching_fixed",
        .family = &rosenbrock,
        .tableau = &ros34prw,
        .order = 3,
        .embedded_order = 2,
        .substeps = 8,
        .partner = "rk4",
        .purpose = "ros34prw, and rk4 where the steps resolve every motion",
    },
    {
        .name = "rodas23w",
        .family = &rosenbrock,
        .tableau = &rodas23w,
        .order = 2,
        .embedded_order = 1,
        .purpose = "fixed steps on algebraic equations; keeps its order with a kept Jacobian",
    },
    {
        .name = "ros23",
        .family = &rosenbrock,
        .tableau = &ros23,
        .order = 2,
        .embedded_order = 1,
        .purpose = "fixed steps at low cost: two stages; keeps its order with a kept Jacobian",
    },
    {
        .name = "lie",
        .family = &rosenbrock,
        .tableau = &lie,
        .order = 1,
        .purpose = "linearly implicit Euler: the cheapest fixed step, strongly damped",
    },
    {
        .name = "midpoint",
        .family = &gauss,
        .collocation = &midpoint,
        .order = 2,
        .purpose = "long undamped motions: conserves the energy of linear elements",
    },
    {
        .name = "gauss4",
        .family = &gauss,
        .collocation = &gauss4,
        .order = 4,
        .purpose = "long undamped motions, as midpoint, at order 4",
    },
    {
        .name = "rk4",
        .family = &explicit_runge_kutta,
        .tableau = &rk4,
        .order = 4,
        .embedded_order = 2,
        .purpose = "fixed steps on non-stiff equations: classical Runge-Kutta method",
    },
    {
        .name = "heun",
        .family = &explicit_runge_kutta,
        .tableau = &heun,
        .order = 2,
        .embedded_order = 1,
        .purpose = "fixed steps on non-stiff equations at low cost: two stages",
    },
    {
        .name = "dopri5",
        .family = &explicit_runge_kutta,
        .tableau = &dopri5,
        .order = 5,
        .error_order = 4,
        .purpose = "error control on non-stiff equations: Dormand-Prince method",
    },
};

const int bgc_method_count = sizeof bgc_methods / sizeof *bgc_methods;
