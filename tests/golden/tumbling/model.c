/* quaternion: a bond graph of model Tumbling, compiled by bgc.
 *
 * Quantities are in SI units. t is time, h what depends on parameters alone, w scratch.
 *
 * Parameters p:
 *     0 com[1]  [m]
 *     1 com[2]  [m]
 *     2 com[3]  [m]
 *     3 inertia[1,1]  [kg*m^2]
 *     4 inertia[1,2]  [kg*m^2]
 *     5 inertia[1,3]  [kg*m^2]
 *     6 inertia[2,1]  [kg*m^2]
 *     7 inertia[2,2]  [kg*m^2]
 *     8 inertia[2,3]  [kg*m^2]
 *     9 inertia[3,1]  [kg*m^2]
 *    10 inertia[3,2]  [kg*m^2]
 *    11 inertia[3,3]  [kg*m^2]
 *    12 twist0[1]
 *    13 twist0[2]
 *    14 twist0[3]
 *    15 twist0[4]
 *    16 twist0[5]
 *    17 twist0[6]
 *    18 angles0[1]  [rad]
 *    19 angles0[2]  [rad]
 *    20 angles0[3]  [rad]
 *    21 pose.r0[1]  [m]
 *    22 pose.r0[2]  [m]
 *    23 pose.r0[3]  [m]
 *    24 pose.angles0[1]  [rad]
 *    25 pose.angles0[2]  [rad]
 *    26 pose.angles0[3]  [rad]
 *    27 pose.attitude.angles0[1]  [rad]
 *    28 pose.attitude.angles0[2]  [rad]
 *    29 pose.attitude.angles0[3]  [rad]
 *
 * States x:
 *     0 free.body.p[1]  [N*s]
 *     1 free.body.p[2]  [N*s]
 *     2 free.body.p[3]  [N*s]
 *     3 free.body.p[4]  [N*m*s]
 *     4 free.body.p[5]  [N*m*s]
 *     5 free.body.p[6]  [N*m*s]
 *     6 pose.attitude.h[1]
 *     7 pose.attitude.h[2]
 *     8 pose.attitude.h[3]
 *     9 pose.attitude.h[4]
 *    10 pose.r[1]  [m]
 *    11 pose.r[2]  [m]
 *    12 pose.r[3]  [m]
 *
 * Outputs y:
 *     0 linear[1]
 *     1 linear[2]
 *     2 linear[3]
 *     3 angular[1]
 *     4 angular[2]
 *     5 angular[3]
 *     6 momentum[1]  [N*s]
 *     7 momentum[2]  [N*s]
 *     8 momentum[3]  [N*s]
 *     9 momentum[4]  [N*m*s]
 *    10 momentum[5]  [N*m*s]
 *    11 momentum[6]  [N*m*s]
 *    12 twist[1]  [m/s]
 *    13 twist[2]  [m/s]
 *    14 twist[3]  [m/s]
 *    15 twist[4]  [rad/s]
 *    16 twist[5]  [rad/s]
 *    17 twist[6]  [rad/s]
 */
#include "bgc.h"

#include <math.h>

static inline double model_max(double a, double b)
{
    return a > b || a != a ? a : b;
}

static inline double model_less(double a, double b)
{
    return a < b ? 1.0 : a >= b ? 0.0 : (double)NAN;
}

static inline double model_at_most(double a, double b)
{
    return a <= b ? 1.0 : a > b ? 0.0 : (double)NAN;
}

/* Everything that depends on parameters alone. */
static void model_prepare_1(const double *restrict p, double *restrict h, double *restrict w)
{
    const double v1 = 1.0 / p[3];
    w[-16] = v1;
    const double v2 = v1 * (p[5] * p[9]);
    w[-15] = v2;
    const double v3 = v1 * (p[4] * p[6]);
    w[-14] = v3;
    const double v4 = p[7] - v3;
    w[-13] = v4;
    const double v5 = 1.0 / v4;
    w[-12] = v5;
    const double v6 = p[8] - v1 * (p[5] * p[6]);
    w[-11] = v6;
    const double v7 = p[10] - v1 * (p[4] * p[9]);
    w[-10] = v7;
    const double v8 = v5 * (v6 * v7);
    w[-9] = v8;
    const double v9 = p[11] - v2 - v8;
    h[54] = v9;
    w[-8] = v9;
    const double v10 = 1.0 / v9;
    h[11] = v10;
    w[-7] = v10;
    const double v11 = v6 * v5;
    const double v12 = v1 * (p[2] * p[6]);
    w[-6] = v12;
    const double v13 = p[0] + v1 * (p[2] * p[9]) - v5 * (v12 * v7);
    w[-5] = v13;
    const double v14 = v12 * v5;
    w[-4] = v14;
    const double v15 = v10 * (v11 * v13) - v14;
    h[0] = v15;
    w[-3] = v15;
    const double v16 = p[2] * v5;
    w[-2] = v16;
    const double v17 = p[1] + v5 * (p[2] * v7);
    w[-1] = v17;
    const double v18 = v16 + v10 * (v11 * v17);
    h[1] = v18;
    w[0] = v18;
    const double v19 = p[0] + v1 * (p[1] * p[6]);
    w[1] = v19;
    const double v20 = v5 * (v19 * v7) - v1 * (p[1] * p[9]);
    w[2] = v20;
    const double v21 = v19 * v5 + v10 * (v11 * v20);
    h[2] = v21;
    w[3] = v21;
    const double v22 = p[6] * v1;
    w[4] = v22;
    const double v23 = p[9] * v1 - v5 * (v22 * v7);
    w[5] = v23;
    const double v24 = v10 * (v11 * v23) - v22 * v5;
    h[3] = v24;
    w[6] = v24;
    const double v25 = v7 * v5;
    w[7] = v25;
    const double v26 = v5 + v10 * (v11 * v25);
    h[4] = v26;
    w[8] = v26;
    h[5] = v11 * v10;
    h[6] = v17 * v10;
    h[7] = v13 * v10;
    h[8] = v20 * v10;
    h[9] = v23 * v10;
    h[10] = v25 * v10;
    const double v27 = v1 * (p[2] * p[4]);
    w[9] = v27;
    const double v28 = v27 * v5;
    w[10] = v28;
    const double v29 = p[4] * v1;
    w[11] = v29;
    const double v30 = v5 * (v29 * v6) - p[5] * v1;
    w[12] = v30;
    const double v31 = v28 + v10 * (v30 * v17);
    h[12] = v31;
    w[13] = v31;
    const double v32 = p[2] * v1 + v5 * (v27 * v22);
    w[14] = v32;
    const double v33 = v32 - v10 * (v30 * v13);
    h[13] = v33;
    w[15] = v33;
    const double v34 = p[1] * v1;
    w[16] = v34;
    const double v35 = v34 + v5 * (v29 * v19) + v10 * (v30 * v20);
    h[14] = v35;
    w[17] = v35;
    const double v36 = v1 + v5 * (v29 * v22) - v10 * (v30 * v23);
    h[15] = v36;
    w[18] = v36;
}

static void model_prepare_2(const double *restrict p, double *restrict h, double *restrict w)
{
    const double v37 = w[11] * w[-12] + w[-7] * (w[12] * w[7]);
    h[-16] = v37;
    w[19] = v37;
    h[-15] = w[12] * w[-7];
    const double v38 = w[-12] * (w[9] * w[-11]) - (p[0] + w[-16] * (p[2] * p[5]));
    w[20] = v38;
    const double v39 = w[-12] * (p[2] * w[9]) + w[-7] * (v38 * w[-1]);
    h[-14] = v39;
    w[21] = v39;
    const double v40 = p[2] * p[2];
    const double v41 = 0.01 + w[-16] * v40 + w[-12] * (w[9] * w[-6]) - w[-7] * (v38 * w[-5]);
    h[-13] = v41;
    w[22] = v41;
    const double v42 = w[-16] * (p[1] * p[2]);
    const double v43 = v42 + w[-12] * (w[9] * w[1]) + w[-7] * (v38 * w[2]);
    h[-12] = v43;
    w[23] = v43;
    const double v44 = w[14] - w[-7] * (v38 * w[5]);
    h[-11] = v44;
    w[24] = v44;
    const double v45 = w[10] + w[-7] * (v38 * w[7]);
    h[-10] = v45;
    w[25] = v45;
    h[-9] = v38 * w[-7];
    const double v46 = p[0] + w[-16] * (p[1] * p[4]);
    const double v47 = w[-16] * (p[1] * p[5]) - w[-12] * (v46 * w[-11]);
    w[26] = v47;
    const double v48 = w[-7] * (v47 * w[-1]) - w[-12] * (p[2] * v46);
    h[-8] = v48;
    w[27] = v48;
    const double v49 = v42 + w[-12] * (v46 * w[-6]) + w[-7] * (v47 * w[-5]);
    h[-7] = v49;
    w[28] = v49;
    const double v50 = 0.01 + w[-16] * (p[1] * p[1]) + w[-12] * (v46 * w[1]) - w[-7] * (v47 * w[2]);
    h[-6] = v50;
    w[29] = v50;
    const double v51 = w[16] + w[-12] * (v46 * w[4]) + w[-7] * (v47 * w[5]);
    h[-5] = v51;
    w[30] = v51;
    const double v52 = v46 * w[-12] - w[-7] * (v47 * w[7]);
    h[-4] = v52;
    w[31] = v52;
    h[-3] = v47 * w[-7];
    const double v53 = p[1] + w[-12] * (p[2] * w[-11]);
    w[32] = v53;
    const double v54 = 0.01 + v40 * w[-12] + w[-7] * (v53 * w[-1]);
    h[-2] = v54;
    w[33] = v54;
    const double v55 = w[-12] * (p[2] * w[-6]) - w[-7] * (v53 * w[-5]);
    h[-1] = v55;
    w[34] = v55;
    const double v56 = w[-12] * (p[2] * w[1]) + w[-7] * (v53 * w[2]);
    h[0] = v56;
    w[35] = v56;
    const double v57 = w[-4] - w[-7] * (v53 * w[5]);
    h[1] = v57;
    w[36] = v57;
}

static void model_prepare_3(const double *restrict p, double *restrict h, double *restrict w)
{
    const double v58 = w[-6] + w[-11] * (w[28] * w[3]);
    h[-16] = v58;
    w[12] = v58;
    h[-15] = w[28] * w[-11];
    const double v59 = p[-14] * 100.0;
    const double v60 = p[-15] * 100.0;
    h[-14] = p[-4] * 100.0 + p[0] * v59 - p[1] * v60;
    const double v61 = p[-16] * 100.0;
    h[-13] = p[-3] * 100.0 - p[-1] * v59 + p[1] * v61;
    h[-12] = p[-2] * 100.0 + p[-1] * v60 - p[0] * v61;
    const double v62 = p[-14] * v59;
    const double v63 = p[-15] * v60;
    const double v64 = p[-13] + (v62 + v63);
    h[5] = v64;
    w[10] = v64;
    const double v65 = p[-16] * v60;
    const double v66 = p[-12] - v65;
    w[7] = v66;
    const double v67 = p[-16] * v59;
    const double v68 = p[-11] - v67;
    w[6] = v68;
    h[-11] = p[-2] * v60 - p[-3] * v59 + p[-1] * v64 + p[0] * v66 + p[1] * v68;
    const double v69 = p[-10] - v65;
    w[5] = v69;
    const double v70 = p[-16] * v61;
    const double v71 = p[-9] + (v62 + v70);
    h[6] = v71;
    w[0] = v71;
    const double v72 = p[-15] * v59;
    const double v73 = p[-8] - v72;
    w[-3] = v73;
    h[-10] = p[-4] * v59 - p[-2] * v61 + p[-1] * v69 + p[0] * v71 + p[1] * v73;
    const double v74 = p[-7] - v67;
    w[-8] = v74;
    const double v75 = p[-6] - v72;
    w[-10] = v75;
    const double v76 = p[-5] + (v63 + v70);
    h[7] = v76;
    w[-16] = v76;
    h[-9] = p[-3] * v61 - p[-4] * v60 + p[-1] * v74 + p[0] * v75 + p[1] * v76;
    const double v77 = 0.5 * p[13];
    const double v78 = cos(v77);
    const double v79 = 0.5 * p[12];
    const double v80 = cos(v79);
    const double v81 = 0.5 * p[11];
    const double v82 = cos(v81);
    const double v83 = v80 * v82;
    const double v84 = sin(v77);
    const double v85 = sin(v79);
    const double v86 = sin(v81);
    const double v87 = v85 * v86;
    h[-8] = v78 * v83 + v84 * v87;
    const double v88 = v80 * v86;
    const double v89 = v85 * v82;
    h[-7] = v78 * v88 - v84 * v89;
    h[-6] = v78 * v89 + v84 * v88;
    h[-5] = v84 * v83 - v78 * v87;
    h[-1] = 1.0 / w[29];
    h[0] = 1.0 / w[18];
    h[1] = 1.0 / w[25];
    h[2] = 1.0 / w[14];
    h[3] = 1.0 / w[4];
}

static void model_prepare_4(const double *restrict p, double *restrict h, double *restrict w)
{
    const double v90 = model_less(model_max(model_max(sqrt(fabs(w[13] * w[3])), fabs(w[10])),
            fabs(w[8])) * 1e-09, fabs(w[10] - w[8]));
    h[-4] = v90 == 0.0 ? 1.0 : v90 == v90 ? 0.0 : v90;
    const double v91 = model_less(1e-09 * model_max(model_max(sqrt(fabs(w[13] * w[-13])),
            fabs(w[9])), fabs(w[-5])), fabs(w[9] - w[-5]));
    h[-3] = v91 == 0.0 ? 1.0 : v91 == v91 ? 0.0 : v91;
    const double v92 = model_less(1e-09 * model_max(model_max(sqrt(fabs(w[3] * w[-13])),
            fabs(w[0])), fabs(w[-7])), fabs(w[0] - w[-7]));
    h[-2] = v92 == 0.0 ? 1.0 : v92 == v92 ? 0.0 : v92;
    const double v93 = fabs(w[-9]);
    const double v94 = model_at_most(v93, 1.7976931348623157e+308);
    h[-1] = v94 == 0.0 ? v93 : v94 == v94 ? v93 - 3.552713678800501e-15 * (fabs(p[11]) +
            (fabs(w[-10]) + fabs(w[-16]))) : v94;
    const double v95 = fabs(w[-14]);
    const double v96 = model_at_most(v95, 1.7976931348623157e+308);
    h[0] = v96 == 0.0 ? v95 : v96 == v96 ? v95 - 3.552713678800501e-15 * (fabs(w[-15]) +
            fabs(p[7])) : v96;
    const double v97 = fabs(w[-11]) + fabs(w[4]) + fabs(w[1]) + fabs(w[-6]) + fabs(w[-2]) +
            fabs(w[-12]) + fabs(w[7]) + fabs(w[5]) + fabs(w[2]) + fabs(w[-1]) + fabs(w[-4]);
    w[6] = v97 + fabs(w[11]) + fabs(w[18]) + fabs(w[17]) + fabs(w[16]) + fabs(w[14]) + fabs(w[12])
            + fabs(w[25]) + fabs(w[30]) + fabs(w[29]) + fabs(w[28]);
}

static void model_prepare_5(const double *restrict p, double *restrict h, double *restrict w)
{
    const double v98 = w[-16] + fabs(w[5]) + fabs(w[4]) + fabs(w[-3]) + fabs(w[2]) + fabs(w[1]) +
            fabs(w[0]) + fabs(w[-1]) + fabs(w[-2]) + fabs(w[9]) + fabs(w[-7]);
    h[1] = model_at_most(fabs(v98 + fabs(w[13]) + fabs(w[12]) + fabs(w[11]) + fabs(w[10])),
            1.7976931348623157e+308);
    h[-16] = p[-2];
    h[-15] = p[-1];
    h[-14] = p[0];
}

static void model_prepare(const double *p, double *h, double *w)
{
    model_prepare_1(p, h, w + 16);
    model_prepare_2(p, h + 32, w + 16);
    model_prepare_3(p + 16, h + 50, w + 20);
    model_prepare_4(p, h + 62, w + 17);
    model_prepare_5(p + 23, h + 62, w + 39);
}

/* The right-hand sides f of M y' = f. */
static void model_rhs_1(
    const double *restrict h, const double *restrict x, double *restrict f, double *restrict w)
{
    const double v1 = x[1] * h[-16] - x[0] * h[-15] + x[2] * h[-14] + x[3] * h[-13] + x[4] * h[-12]
            - x[5] * h[-11];
    w[0] = v1;
    const double v2 = x[0] * h[-10] - x[1] * h[-9] - x[2] * h[-8] - x[3] * h[-7] - x[4] * h[-6] +
            x[5] * h[-5];
    w[1] = v2;
    f[0] = -(x[2] * v1 - x[1] * v2);
    const double v3 = x[0] * h[-4] + x[1] * h[-3] - x[2] * h[-2] + x[3] * h[-1] - x[4] * h[0] +
            x[5] * h[1];
    w[2] = v3;
    f[1] = -(x[0] * v2 - x[2] * v3);
    f[2] = -(x[1] * v3 - x[0] * v1);
    const double v4 = x[0] * h[2] + x[1] * h[3] - x[2] * h[4] + x[3] * h[5] - x[4] * h[6] + x[5] *
            h[7];
    w[3] = v4;
    const double v5 = x[0] * h[8] - x[1] * h[9] + x[2] * h[10] - x[3] * h[11] + x[4] * h[12] + x[5]
            * h[13];
    w[4] = v5;
    f[3] = -(x[2] * v4 - x[1] * v5 + x[5] * v1 - x[4] * v2);
    const double v6 = x[0] * h[14] + x[1] * h[15] - x[2] * h[16] + x[3] * h[17] - x[4] * h[18] +
            x[5] * h[19];
    w[5] = v6;
    f[4] = -(x[0] * v5 - x[2] * v6 - x[5] * v3 + x[3] * v2);
}

static void model_rhs_2(const double *restrict x, double *restrict f, double *restrict w)
{
    f[5] = -(x[1] * w[5] - x[0] * w[3] + x[4] * w[2] - x[3] * w[0]);
    f[6] = -(0.5 * (x[7] * w[2] + x[8] * w[0] + x[9] * w[1]));
    f[7] = 0.5 * (x[6] * w[2] + (x[8] * w[1] - w[0] * x[9]));
    f[8] = 0.5 * (x[6] * w[0] + (w[2] * x[9] - x[7] * w[1]));
    f[9] = 0.5 * (x[6] * w[1] + (x[7] * w[0] - w[2] * x[8]));
    const double v7 = x[7] * x[7];
    const double v8 = x[8] * x[8];
    const double v9 = x[9] * x[9];
    const double v10 = 2.0 / (x[6] * x[6] + v7 + v8 + v9);
    const double v11 = x[7] * x[8];
    const double v12 = x[6] * x[9];
    const double v13 = x[7] * x[9];
    const double v14 = x[6] * x[8];
    f[10] = (1.0 - v10 * (v8 + v9)) * w[5] + v10 * (v11 - v12) * w[3] + v10 * (v13 + v14) * w[4];
    const double v15 = x[8] * x[9];
    const double v16 = x[6] * x[7];
    f[11] = w[5] * (v10 * (v11 + v12)) + w[3] * (1.0 - v10 * (v7 + v9)) + w[4] * (v10 * (v15 -
            v16));
    f[12] = w[5] * (v10 * (v13 - v14)) + w[3] * (v10 * (v15 + v16)) + w[4] * (1.0 - v10 * (v7 +
            v8));
}

static void model_rhs(
    const double *h, double t, const double *x, const double *u, double *f, double *w)
{
    (void)t, (void)u;
    model_rhs_1(h + 16, x, f, w);
    model_rhs_2(x, f, w);
}

/* The entries of df/dx in the order of jac_row and jac_col, and df/dt. */
static void model_jacobian_1(
    const double *restrict h, const double *restrict x, double *restrict jac, double *restrict w)
{
    jac[-16] = x[1] * h[-10] + x[2] * h[-15];
    const double v1 = x[0] * h[-10];
    const double v2 = x[1] * h[-9];
    const double v3 = x[3] * h[-7];
    w[0] = v3;
    const double v4 = x[4] * h[-6];
    w[1] = v4;
    const double v5 = v1 - v2 - x[2] * h[-8] - v3 - v4 + x[5] * h[-5];
    w[2] = v5;
    jac[-15] = v5 - v2 - x[2] * h[-16];
    const double v6 = x[2] * h[-14];
    const double v7 = x[0] * h[-15];
    const double v8 = x[3] * h[-13];
    w[3] = v8;
    const double v9 = x[5] * h[-11];
    w[4] = v9;
    const double v10 = x[1] * h[-16] - v7 + v6 + v8 + x[4] * h[-12] - v9;
    w[5] = v10;
    jac[-14] = -(v6 + (v10 + x[1] * h[-8]));
    jac[-13] = -(x[1] * h[-7] + x[2] * h[-13]);
    jac[-12] = -(x[1] * h[-6] + x[2] * h[-12]);
    jac[-11] = x[1] * h[-5] + x[2] * h[-11];
    jac[-10] = x[2] * h[-4] - (v1 + v5);
    jac[-9] = x[0] * h[-9] + x[2] * h[-3];
    const double v11 = x[1] * h[-3];
    const double v12 = x[2] * h[-2];
    const double v13 = x[4] * h[0];
    w[6] = v13;
    const double v14 = x[5] * h[1];
    w[7] = v14;
    const double v15 = x[0] * h[-4] + v11 - v12 + x[3] * h[-1] - v13 + v14;
    w[8] = v15;
    jac[-8] = v15 + x[0] * h[-8] - v12;
    jac[-7] = x[0] * h[-7] + x[2] * h[-1];
    jac[-6] = x[0] * h[-6] - x[2] * h[0];
    jac[-5] = x[2] * h[1] - x[0] * h[-5];
    jac[-4] = v10 - v7 - x[1] * h[-4];
    jac[-3] = x[0] * h[-16] - v15 - v11;
    jac[-2] = x[0] * h[-14] + x[1] * h[-2];
    jac[-1] = x[0] * h[-13] - x[1] * h[-1];
    jac[0] = x[0] * h[-12] + x[1] * h[0];
    jac[1] = -(x[0] * h[-11] + x[1] * h[1]);
    jac[2] = x[1] * h[8] - x[2] * h[2] + x[4] * h[-10] + x[5] * h[-15];
    w[9] = x[0] * h[8];
    w[10] = x[1] * h[9];
}

static void model_jacobian_2(
    const double *restrict h, const double *restrict x, double *restrict jac, double *restrict w)
{
    const double v16 = w[9] - w[10] + x[2] * h[8] - x[3] * h[9] + x[4] * h[10] + x[5] * h[11];
    w[11] = v16;
    jac[-8] = v16 - w[10] - x[2] * h[1] - x[4] * h[-11] - x[5] * h[-18];
    const double v17 = x[2] * h[2];
    const double v18 = x[0] * h[0];
    w[12] = v18;
    const double v19 = v18 + x[1] * h[1] - v17 + x[3] * h[3] - x[4] * h[4] + x[5] * h[5];
    w[13] = v19;
    jac[-7] = v17 + (x[1] * h[8] - v19) - x[4] * h[-10] - x[5] * h[-16];
    jac[-6] = -(x[1] * h[9] + x[2] * h[3] + x[4] * h[-9] + x[5] * h[-15]);
    jac[-5] = w[2] + x[1] * h[10] + x[2] * h[4] - w[1] - x[5] * h[-14];
    jac[-4] = w[4] + (x[1] * h[11] - w[5] - x[2] * h[5] + x[4] * h[-7]);
    jac[-3] = x[2] * h[12] - (w[9] + v16) - x[3] * h[-12] + x[5] * h[-6];
    jac[-2] = x[0] * h[7] + x[2] * h[13] + x[3] * h[-11] + x[5] * h[-5];
    const double v20 = x[1] * h[13];
    w[14] = v20;
    const double v21 = x[2] * h[14];
    const double v22 = x[0] * h[12] + v20 - v21 + x[3] * h[15] - x[4] * h[16] + x[5] * h[17];
    w[15] = v22;
    jac[-1] = v22 - x[0] * h[8] - v21 + x[3] * h[-10] - x[5] * h[-4];
    jac[0] = w[0] + (x[0] * h[9] - w[2] + x[2] * h[15]) + x[5] * h[-3];
}

static void model_jacobian_3(
    const double *restrict h, const double *restrict x, double *restrict jac, double *restrict w)
{
    jac[-16] = x[3] * h[-6] - (x[0] * h[12] + x[2] * h[18]) - x[5] * h[0];
    jac[-15] = w[7] + (w[8] - x[0] * h[13] + x[2] * h[19] - x[3] * h[-5]);
    jac[-14] = w[12] + w[13] - x[1] * h[14] - x[3] * h[-15] - x[4] * h[-4];
    jac[-13] = x[0] * h[3] - w[15] - w[14] + x[3] * h[-16] - x[4] * h[-3];
    jac[-12] = x[1] * h[16] - x[0] * h[4] + x[3] * h[-14] + x[4] * h[-2];
    jac[-11] = w[3] + (w[5] + x[0] * h[5] - x[1] * h[17]) - x[4] * h[-1];
    jac[-10] = w[6] + (x[1] * h[18] - (w[8] + x[0] * h[6]) + x[3] * h[-12]);
    jac[-9] = x[0] * h[7] - x[1] * h[19] - x[3] * h[-11] - x[4] * h[1];
    const double v23 = 0.5 * x[8];
    w[10] = v23;
    const double v24 = 0.5 * x[9];
    w[9] = v24;
    const double v25 = 0.5 * x[7];
    w[4] = v25;
    jac[-8] = h[-15] * v23 - h[-10] * v24 - h[-4] * v25;
    jac[-7] = h[-9] * v24 - h[-16] * v23 - h[-3] * v25;
    jac[-6] = h[-8] * v24 - h[-14] * v23 + h[-2] * v25;
    jac[-5] = h[-7] * v24 - h[-13] * v23 - h[-1] * v25;
    jac[-4] = h[-6] * v24 - h[-12] * v23 + h[0] * v25;
    jac[-3] = h[-11] * v23 - h[-5] * v24 - h[1] * v25;
    const double v26 = 0.5 * w[8];
    jac[7] = v26;
    jac[18] = v26;
    const double v27 = -v26;
    jac[-2] = v27;
    jac[27] = v27;
    const double v28 = 0.5 * w[5];
    jac[16] = v28;
    jac[26] = v28;
    const double v29 = -v28;
    jac[-1] = v29;
    jac[9] = v29;
    const double v30 = 0.5 * w[2];
    jac[8] = v30;
    jac[25] = v30;
    const double v31 = -v30;
    jac[0] = v31;
    jac[17] = v31;
    w[1] = 0.5 * x[6];
}

static void model_jacobian_4(
    const double *restrict h, const double *restrict x, double *restrict jac, double *restrict w)
{
    jac[-16] = h[-10] * w[10] + h[-15] * w[9] + h[-4] * w[1];
    jac[-15] = h[-3] * w[1] - (h[-9] * w[10] + h[-16] * w[9]);
    jac[-14] = -(h[-8] * w[10] + h[-14] * w[9] + h[-2] * w[1]);
    jac[-13] = h[-1] * w[1] - (h[-7] * w[10] + h[-13] * w[9]);
    jac[-12] = -(h[-6] * w[10] + h[-12] * w[9] + h[0] * w[1]);
    jac[-11] = h[-5] * w[10] + h[-11] * w[9] + h[1] * w[1];
    jac[-7] = h[-4] * w[9] - (h[-10] * w[4] + h[-15] * w[1]);
    jac[-6] = h[-9] * w[4] + h[-16] * w[1] + h[-3] * w[9];
    jac[-5] = h[-8] * w[4] + h[-14] * w[1] - h[-2] * w[9];
    jac[-4] = h[-7] * w[4] + h[-13] * w[1] + h[-1] * w[9];
    jac[-3] = h[-6] * w[4] + h[-12] * w[1] - h[0] * w[9];
    jac[-2] = h[1] * w[9] - (h[-5] * w[4] + h[-11] * w[1]);
    jac[2] = h[-10] * w[1] - h[-15] * w[4] - h[-4] * w[10];
    jac[3] = h[-16] * w[4] - h[-9] * w[1] - h[-3] * w[10];
    jac[4] = h[-14] * w[4] - h[-8] * w[1] + h[-2] * w[10];
    jac[5] = h[-13] * w[4] - h[-7] * w[1] - h[-1] * w[10];
    jac[6] = h[-12] * w[4] - h[-6] * w[1] + h[0] * w[10];
    jac[7] = h[-5] * w[1] - h[-11] * w[4] - h[1] * w[10];
    const double v32 = x[7] * x[7];
    w[14] = v32;
    const double v33 = x[8] * x[8];
    w[12] = v33;
    const double v34 = x[9] * x[9];
    w[8] = v34;
    w[7] = 1.0 / (x[6] * x[6] + v32 + v33 + v34);
}

static void model_jacobian_5(
    const double *restrict h, const double *restrict x, double *restrict jac, double *restrict w)
{
    const double v35 = 2.0 * w[-9];
    w[-15] = v35;
    const double v36 = x[7] * x[9];
    w[-12] = v36;
    const double v37 = x[6] * x[8];
    w[-7] = v37;
    const double v38 = v36 + v37;
    const double v39 = v35 * v38;
    const double v40 = x[7] * x[8];
    const double v41 = x[6] * x[9];
    const double v42 = v40 - v41;
    const double v43 = v35 * v42;
    const double v44 = w[-4] + w[-8];
    const double v45 = 1.0 - v35 * v44;
    jac[-10] = h[-10] * v39 + h[-16] * v43 + h[-4] * v45;
    jac[-9] = h[-15] * v43 - h[-9] * v39 + h[-3] * v45;
    jac[-8] = h[-8] * v39 - h[-14] * v43 - h[-2] * v45;
    jac[-7] = h[-13] * v43 - h[-7] * v39 + h[-1] * v45;
    jac[-6] = h[-6] * v39 - h[-12] * v43 - h[0] * v45;
    jac[-5] = h[-5] * v39 + h[-11] * v43 + h[1] * v45;
    const double v46 = v35 * w[-5];
    w[-6] = v46;
    const double v47 = x[8] * v46;
    w[-10] = v47;
    const double v48 = v38 * w[-5] + v42 * w[-3] - v44 * w[-1];
    const double v49 = 2.0 * (w[-9] * w[-9]);
    const double v50 = (x[6] + x[6]) * v49;
    w[-11] = v50;
    const double v51 = v35 * w[-3];
    w[-13] = v51;
    const double v52 = x[9] * v51;
    w[-14] = v52;
    jac[-4] = v47 - v48 * v50 - v52;
    const double v53 = x[8] * v51;
    w[-16] = v53;
    const double v54 = x[9] * v46;
    w[0] = v54;
    const double v55 = x[7] + x[7];
    w[1] = v55;
    const double v56 = v55 * v49;
    w[2] = v56;
    jac[-3] = v53 + (v54 - v48 * v56);
    const double v57 = x[7] * v51;
    w[3] = v57;
    const double v58 = x[6] * v46;
    w[4] = v58;
    const double v59 = x[8] + x[8];
    w[5] = v59;
    const double v60 = v35 * w[-1];
    w[6] = v60;
    const double v61 = v59 * v49;
    w[7] = v61;
    jac[-2] = v57 + (v58 - (v59 * v60 + v48 * v61));
    const double v62 = x[7] * v46;
    w[8] = v62;
    const double v63 = x[9] + x[9];
    w[9] = v63;
    const double v64 = v63 * v49;
    w[10] = v64;
    const double v65 = x[6] * v51;
    w[11] = v65;
    jac[-1] = v62 - (v63 * v60 + v48 * v64) - v65;
    const double v66 = x[8] * x[9];
    w[12] = v66;
    const double v67 = x[6] * x[7];
    w[13] = v67;
    const double v68 = v66 - v67;
    w[14] = v68;
    const double v69 = v35 * v68;
    w[15] = v69;
    const double v70 = w[-2] + w[-8];
    w[16] = v70;
    const double v71 = 1.0 - v35 * v70;
    w[17] = v71;
    const double v72 = v40 + v41;
    w[18] = v72;
    const double v73 = v35 * v72;
    w[19] = v73;
    jac[0] = h[-10] * v69 + h[-16] * v71 + h[-4] * v73;
}

static void model_jacobian_6(
    const double *restrict h, const double *restrict x, double *restrict jac, double *restrict w)
{
    jac[-16] = h[-15] * w[13] - h[-9] * w[11] + h[-3] * w[15];
    jac[-15] = h[-8] * w[11] - h[-14] * w[13] - h[-2] * w[15];
    jac[-14] = h[-13] * w[13] - h[-7] * w[11] + h[-1] * w[15];
    jac[-13] = h[-6] * w[11] - h[-12] * w[13] - h[0] * w[15];
    jac[-12] = h[-5] * w[11] + h[-11] * w[13] + h[1] * w[15];
    const double v74 = x[9] * w[2];
    const double v75 = w[-9] * w[10] - w[-7] * w[12] + w[-5] * w[14];
    jac[-11] = v74 - (v75 * w[-15] + w[4]);
    const double v76 = x[8] * w[2];
    jac[-10] = v76 - (w[-3] * w[-17] + v75 * w[-2] + w[0]);
    const double v77 = x[7] * w[2];
    w[-13] = v77;
    jac[-9] = w[-4] - v75 * w[3] + v77;
    const double v78 = x[6] * w[2];
    w[-12] = v78;
    jac[-8] = w[-14] - (w[5] * w[-17] + v75 * w[6]) + v78;
    const double v79 = w[-6] + w[-8];
    const double v80 = 1.0 - w[-19] * v79;
    const double v81 = w[8] + w[9];
    const double v82 = w[-19] * v81;
    const double v83 = w[-16] - w[-11];
    const double v84 = w[-19] * v83;
    jac[-7] = h[-10] * v80 + h[-16] * v82 + h[-4] * v84;
    jac[-6] = h[-15] * v82 - h[-9] * v80 + h[-3] * v84;
    jac[-5] = h[-8] * v80 - h[-14] * v82 - h[-2] * v84;
    jac[-4] = h[-13] * v82 - h[-7] * v80 + h[-1] * v84;
    jac[-3] = h[-6] * v80 - h[-12] * v82 - h[0] * v84;
    jac[-2] = h[-5] * v80 + h[-11] * v82 + h[1] * v84;
    const double v85 = w[-7] * v81 - w[-9] * v79 + w[-5] * v83;
    w[16] = v85;
    jac[-1] = w[-1] - v85 * w[-15] - v76;
    jac[0] = w[7] - (w[-3] * w[-10] + v85 * w[-2]) + v74;
}

static void model_jacobian_7(double *restrict jac, double *restrict dfdt, double *restrict w)
{
    jac[-1] = w[-14] - (w[5] * w[-6] + w[20] * w[7]) - w[-8];
    jac[0] = w[-16] - w[20] * w[10] + w[-9];
    for (int k = 0; k < 13; k++) dfdt[k] = 0.0;
}

static void model_jacobian(
    const double *h, double t, const double *x, const double *u, double *jac, double *dfdt, double *w)
{
    (void)t, (void)u;
    model_jacobian_1(h + 16, x, jac + 16, w);
    model_jacobian_2(h + 18, x, jac + 27, w);
    model_jacobian_3(h + 16, x, jac + 44, w);
    model_jacobian_4(h + 16, x, jac + 61, w);
    model_jacobian_5(h + 34, x, jac + 82, w + 16);
    model_jacobian_6(h + 34, x, jac + 99, w + 20);
    model_jacobian_7(jac + 101, dfdt, w + 16);
}

/* Stored energy, supplied power, dissipated power. */
static void model_energy(
    const double *h, double t, const double *x, const double *u, double *out, double *w)
{
    (void)t, (void)u, (void)w;
    const double v1 = x[0] * (x[0] * h[30] + x[1] * h[31] - x[2] * h[32] + x[3] * h[33] - x[4] *
            h[34] + x[5] * h[35]) + x[1] * (x[0] * h[18] + x[1] * h[19] - x[2] * h[20] + x[3] *
            h[21] - x[4] * h[22] + x[5] * h[23]);
    const double v2 = v1 + x[2] * (x[0] * h[24] - x[1] * h[25] + x[2] * h[26] - x[3] * h[27] + x[4]
            * h[28] + x[5] * h[29]) + x[3] * (x[0] * h[12] + x[1] * h[13] - x[2] * h[14] + x[3] *
            h[15] - x[4] * h[16] + x[5] * h[17]);
    const double v3 = v2 + x[4] * (x[1] * h[0] - x[0] * h[1] + x[2] * h[2] + x[3] * h[3] + x[4] *
            h[4] - x[5] * h[5]) + x[5] * (x[0] * h[6] - x[1] * h[7] - x[2] * h[8] - x[3] * h[9] -
            x[4] * h[10] + x[5] * h[11]);
    out[0] = 0.5 * v3;
    out[1] = 0.0;
    out[2] = 0.0;
}

/* What the scene observes. */
static void model_outputs_1(const double *restrict h, const double *restrict x, double *restrict y)
{
    const double v1 = x[7] * x[7];
    const double v2 = x[8] * x[8];
    const double v3 = x[9] * x[9];
    const double v4 = 2.0 / (x[6] * x[6] + v1 + v2 + v3);
    const double v5 = 1.0 - v4 * (v2 + v3);
    const double v6 = x[7] * x[8];
    const double v7 = x[6] * x[9];
    const double v8 = v4 * (v6 - v7);
    const double v9 = x[7] * x[9];
    const double v10 = x[6] * x[8];
    const double v11 = v4 * (v9 + v10);
    const double v12 = x[0] * v5 + x[1] * v8 + x[2] * v11;
    y[0] = v12;
    const double v13 = v4 * (v6 + v7);
    const double v14 = 1.0 - v4 * (v1 + v3);
    const double v15 = x[8] * x[9];
    const double v16 = x[6] * x[7];
    const double v17 = v4 * (v15 - v16);
    const double v18 = x[0] * v13 + x[1] * v14 + x[2] * v17;
    y[1] = v18;
    const double v19 = v4 * (v9 - v10);
    const double v20 = v4 * (v15 + v16);
    const double v21 = 1.0 - v4 * (v1 + v2);
    const double v22 = x[0] * v19 + x[1] * v20 + x[2] * v21;
    y[2] = v22;
    y[3] = x[3] * v5 + x[4] * v8 + x[5] * v11 + (v22 * x[11] - v18 * x[12]);
    y[4] = x[3] * v13 + x[4] * v14 + x[5] * v17 + (v12 * x[12] - v22 * x[10]);
    y[5] = x[3] * v19 + x[4] * v20 + x[5] * v21 + (v18 * x[10] - v12 * x[11]);
    y[12] = x[0] * h[-4] + x[1] * h[-3] - x[2] * h[-2] + x[3] * h[-1] - x[4] * h[0] + x[5] * h[1];
    y[13] = x[0] * h[-16] + x[1] * h[-15] - x[2] * h[-14] + x[3] * h[-13] - x[4] * h[-12] + x[5] *
            h[-11];
}

static void model_outputs_2(const double *restrict h, const double *restrict x, double *restrict y)
{
    y[-3] = x[0] * h[8] - x[1] * h[9] + x[2] * h[10] - x[3] * h[11] + x[4] * h[12] + x[5] * h[13];
    y[-2] = x[0] * h[-4] + x[1] * h[-3] - x[2] * h[-2] + x[3] * h[-1] - x[4] * h[0] + x[5] * h[1];
    y[-1] = x[1] * h[-16] - x[0] * h[-15] + x[2] * h[-14] + x[3] * h[-13] + x[4] * h[-12] - x[5] *
            h[-11];
    y[0] = x[0] * h[-10] - x[1] * h[-9] - x[2] * h[-8] - x[3] * h[-7] - x[4] * h[-6] + x[5] * h[-5];
    y[-11] = x[0];
    y[-10] = x[1];
    y[-9] = x[2];
    y[-8] = x[3];
    y[-7] = x[4];
    y[-6] = x[5];
}

static void model_outputs(
    const double *h, double t, const double *x, const double *u, double *y, double *w)
{
    (void)t, (void)u, (void)w;
    model_outputs_1(h + 34, x, y);
    model_outputs_2(h + 16, x, y + 17);
}

/* Commands to the devices. */
static void model_commands(
    const double *h, double t, const double *x, const double *u, double *c, double *w)
{
    (void)h, (void)t, (void)x, (void)u, (void)c, (void)w;
}

/* Conditions that have to hold: nonzero where they do. */
static void model_asserts(
    const double *h, double t, const double *x, const double *u, double *a, double *w)
{
    (void)h, (void)t, (void)x, (void)u, (void)a, (void)w;
}

/* States that are set after each completed step. */
static void model_project(const double *h, double t, double *x, double *w)
{
    (void)h, (void)t;
    const double v1 = 1.0 / sqrt(x[6] * x[6] + x[7] * x[7] + x[8] * x[8] + x[9] * x[9]);
    w[0] = x[6] * v1;
    w[1] = x[7] * v1;
    w[2] = x[8] * v1;
    w[3] = x[9] * v1;
    x[6] = w[0];
    x[7] = w[1];
    x[8] = w[2];
    x[9] = w[3];
}

/* The entries of M in the order of mass_row and mass_col. */
static void model_mass(const double *h, double *m, double *w)
{
    (void)h, (void)m, (void)w;
}

/* The states at the start. */
static void model_initial(const double *h, double t, const double *u, double *x, double *w)
{
    (void)t, (void)u, (void)w;
    for (int k = 0; k < 13; k++) x[k] = h[k + 36];
}

/* The unit in which the error of each state is measured. */
static void model_scale(const double *h, double *scale, double *w)
{
    (void)w;
    scale[0] = h[49];
    scale[1] = h[50];
    scale[2] = h[51];
    scale[3] = h[52];
    scale[4] = h[53];
    scale[5] = h[54];
    scale[6] = 1.0;
    scale[7] = 1.0;
    scale[8] = 1.0;
    scale[9] = 1.0;
    scale[10] = 1.0;
    scale[11] = 1.0;
    scale[12] = 1.0;
}

/* Parameters and expressions of them that have to be positive. */
static void model_positive(const double *p, const double *h, double *check, double *w)
{
    (void)p, (void)w;
    for (int k = 0; k < 9; k++) check[k] = h[k + 55];
}

/* The arguments of functions that may hide pulses. */
static void model_watched(
    const double *h, double t, const double *x, const double *u, double *z, double *w)
{
    (void)h, (void)t, (void)u, (void)w;
    z[0] = x[6] * x[6] + x[7] * x[7] + x[8] * x[8] + x[9] * x[9];
}

/* Defaults of the parameters that are given by other parameters. */
static void model_defaults(double *p, const unsigned char *is_set, double *w)
{
    (void)w;
    if (!is_set[24]) {
        p[24] = p[18];
    }
    if (!is_set[25]) {
        p[25] = p[19];
    }
    if (!is_set[26]) {
        p[26] = p[20];
    }
    if (!is_set[27]) {
        p[27] = p[24];
    }
    if (!is_set[28]) {
        p[28] = p[25];
    }
    if (!is_set[29]) {
        p[29] = p[26];
    }
}

/* Factorises W = c M - J. growth: the sum over the pivots of (c |M_kk| + |J_kk|) / |pivot|,
 * about n_state where no pivot cancels. Nonzero where a pivot is zero or not finite. */
static double model_factor_1(const double *restrict jac, double c, double *restrict lu)
{
    double g = 0.0;
    lu[-49] = 1.0 / c;
    g += c * fabs(lu[-49]);
    lu[-48] = -jac[-7];
    lu[-47] = -jac[-6];
    lu[-46] = -jac[-5];
    lu[-45] = -jac[-4];
    lu[-44] = -jac[-13];
    lu[-43] = -jac[-12];
    lu[-42] = -jac[-11];
    lu[-41] = -jac[-10];
    lu[-40] = -jac[-9];
    lu[-39] = -jac[-8];
    lu[-38] = 1.0 / c;
    g += c * fabs(lu[-38]);
    lu[-37] = -jac[3];
    lu[-36] = -jac[4];
    lu[-35] = -jac[5];
    lu[-34] = -jac[6];
    lu[-33] = -jac[-3];
    lu[-32] = -jac[-2];
    lu[-31] = -jac[-1];
    lu[-30] = -jac[0];
    lu[-29] = -jac[1];
    lu[-28] = -jac[2];
    lu[-27] = 1.0 / c;
    g += c * fabs(lu[-27]);
    lu[-26] = -jac[13];
    lu[-25] = -jac[14];
    lu[-24] = -jac[15];
    lu[-23] = -jac[16];
    lu[-22] = -jac[7];
    lu[-21] = -jac[8];
    lu[-20] = -jac[9];
    lu[-19] = -jac[10];
    lu[-18] = -jac[11];
    lu[-17] = -jac[12];
    lu[-16] = 1.0 / c;
    g += c * fabs(lu[-16]);
    lu[-15] = -jac[-43];
    lu[-14] = -jac[-42];
    lu[-13] = -jac[-41];
    lu[-12] = -jac[-49];
    lu[-11] = -jac[-48];
    lu[-10] = -jac[-47];
    lu[-9] = -jac[-46];
    lu[-8] = -jac[-45];
    lu[-7] = -jac[-44];
    lu[-6] = -jac[-34] * lu[-16];
    lu[-5] = 1.0 / (c - lu[-6] * lu[-15]);
    g += c * fabs(lu[-5]);
    lu[-4] = -jac[-33] - lu[-6] * lu[-14];
    lu[-3] = -jac[-32] - lu[-6] * lu[-13];
    lu[-2] = -jac[-40] - lu[-6] * lu[-12];
    lu[-1] = -jac[-39] - lu[-6] * lu[-11];
    lu[0] = -jac[-38] - lu[-6] * lu[-10];
    lu[1] = -jac[-37] - lu[-6] * lu[-9];
    lu[2] = -jac[-36] - lu[-6] * lu[-8];
    lu[3] = -jac[-35] - lu[-6] * lu[-7];
    lu[4] = -jac[-25] * lu[-16];
    lu[5] = (-jac[-24] - lu[4] * lu[-15]) * lu[-5];
    lu[6] = 1.0 / (c - lu[4] * lu[-14] - lu[5] * lu[-4]);
    g += c * fabs(lu[6]);
    lu[7] = -jac[-23] - lu[4] * lu[-13] - lu[5] * lu[-3];
    lu[8] = -jac[-31] - lu[4] * lu[-12] - lu[5] * lu[-2];
    lu[9] = -jac[-30] - lu[4] * lu[-11] - lu[5] * lu[-1];
    lu[10] = -jac[-29] - lu[4] * lu[-10] - lu[5] * lu[0];
    lu[11] = -jac[-28] - lu[4] * lu[-9] - lu[5] * lu[1];
    lu[12] = -jac[-27] - lu[4] * lu[-8] - lu[5] * lu[2];
    lu[13] = -jac[-26] - lu[4] * lu[-7] - lu[5] * lu[3];
    lu[14] = -jac[-16] * lu[-16];
    lu[15] = (-jac[-15] - lu[14] * lu[-15]) * lu[-5];
    lu[16] = (-jac[-14] - lu[14] * lu[-14] - lu[15] * lu[-4]) * lu[6];
    lu[17] = 1.0 / (c - lu[14] * lu[-13] - lu[15] * lu[-3] - lu[16] * lu[7]);
    g += c * fabs(lu[17]);
    lu[18] = -jac[-22] - lu[14] * lu[-12] - lu[15] * lu[-2] - lu[16] * lu[8];
    lu[19] = -jac[-21] - lu[14] * lu[-11] - lu[15] * lu[-1] - lu[16] * lu[9];
    lu[20] = -jac[-20] - lu[14] * lu[-10] - lu[15] * lu[0] - lu[16] * lu[10];
    return g;
}

static double model_factor_2(const double *restrict jac, double c, double *restrict lu)
{
    double g = 0.0;
    lu[-19] = -jac[50] - lu[-26] * lu[-49] - lu[-25] * lu[-39] - lu[-24] * lu[-29];
    lu[-18] = -jac[51] - lu[-26] * lu[-48] - lu[-25] * lu[-38] - lu[-24] * lu[-28];
    lu[-17] = -jac[52] - lu[-26] * lu[-47] - lu[-25] * lu[-37] - lu[-24] * lu[-27];
    lu[-16] = 1.0 / (c - jac[-16]);
    g += (c + fabs(jac[-16])) * fabs(lu[-16]);
    lu[-15] = -jac[-15];
    lu[-14] = -jac[-14];
    lu[-13] = -jac[-13];
    lu[-12] = -jac[-12];
    lu[-11] = -jac[-11];
    lu[-10] = -jac[-10] * lu[-16];
    lu[-9] = 1.0 / (c - jac[-9] - lu[-10] * lu[-15]);
    g += (c + fabs(jac[-9])) * fabs(lu[-9]);
    lu[-8] = -jac[-8] - lu[-10] * lu[-14];
    lu[-7] = -jac[-7] - lu[-10] * lu[-13];
    lu[-6] = -jac[-6] - lu[-10] * lu[-12];
    lu[-5] = -jac[-5] - lu[-10] * lu[-11];
    lu[-4] = -jac[-4] * lu[-16];
    lu[-3] = (-jac[-3] - lu[-4] * lu[-15]) * lu[-9];
    lu[-2] = 1.0 / (c - jac[-2] - lu[-4] * lu[-14] - lu[-3] * lu[-8]);
    g += (c + fabs(jac[-2])) * fabs(lu[-2]);
    lu[-1] = -jac[-1] - lu[-4] * lu[-13] - lu[-3] * lu[-7];
    lu[0] = -jac[0] - lu[-4] * lu[-12] - lu[-3] * lu[-6];
    lu[1] = -jac[1] - lu[-4] * lu[-11] - lu[-3] * lu[-5];
    lu[2] = -jac[2] * lu[-16];
    lu[3] = (-jac[3] - lu[2] * lu[-15]) * lu[-9];
    lu[4] = (-jac[4] - lu[2] * lu[-14] - lu[3] * lu[-8]) * lu[-2];
    lu[5] = 1.0 / (c - jac[5] - lu[2] * lu[-13] - lu[3] * lu[-7] - lu[4] * lu[-1]);
    g += (c + fabs(jac[5])) * fabs(lu[5]);
    lu[6] = -jac[6] - lu[2] * lu[-12] - lu[3] * lu[-6] - lu[4] * lu[0];
    lu[7] = -jac[7] - lu[2] * lu[-11] - lu[3] * lu[-5] - lu[4] * lu[1];
    lu[8] = -jac[8] * lu[-16];
    lu[9] = (-jac[9] - lu[8] * lu[-15]) * lu[-9];
    lu[10] = (-jac[10] - lu[8] * lu[-14] - lu[9] * lu[-8]) * lu[-2];
    lu[11] = (-jac[11] - lu[8] * lu[-13] - lu[9] * lu[-7] - lu[10] * lu[-1]) * lu[5];
    lu[12] = 1.0 / (c - jac[12] - lu[8] * lu[-12] - lu[9] * lu[-6] - lu[10] * lu[0] - lu[11] * lu[6]);
    g += (c + fabs(jac[12])) * fabs(lu[12]);
    lu[13] = -jac[13] - lu[8] * lu[-11] - lu[9] * lu[-5] - lu[10] * lu[1] - lu[11] * lu[7];
    lu[14] = -jac[14] * lu[-16];
    lu[15] = (-jac[15] - lu[14] * lu[-15]) * lu[-9];
    lu[16] = (-jac[16] - lu[14] * lu[-14] - lu[15] * lu[-8]) * lu[-2];
    lu[17] = (-jac[17] - lu[14] * lu[-13] - lu[15] * lu[-7] - lu[16] * lu[-1]) * lu[5];
    lu[18] = (-jac[18] - lu[14] * lu[-12] - lu[15] * lu[-6] - lu[16] * lu[0] - lu[17] * lu[6]) * lu[12];
    lu[19] = 1.0 / (c - jac[19] - lu[14] * lu[-11] - lu[15] * lu[-5] - lu[16] * lu[1] - lu[17] * lu[7] - lu[18] * lu[13]);
    g += (c + fabs(jac[19])) * fabs(lu[19]);
    return g;
}

static int model_factor(
    const double *m, const double *jac, double c, double *lu, double *growth)
{
    (void)m;
    double g = 0.0;
    g += model_factor_1(jac + 85, c, lu + 49);
    g += model_factor_2(jac + 16, c, lu + 89);
    *growth = g;
    return g < (double)INFINITY ? 0 : 1;
}

/* b := W^-1 b. */
static void model_solve_1(const double *restrict lu, double *restrict b)
{
    b[7] = b[7] - lu[27] * b[6];
    b[8] = b[8] - lu[37] * b[6] - lu[38] * b[7];
    b[9] = b[9] - lu[47] * b[6] - lu[48] * b[7] - lu[49] * b[8];
    b[1] = b[1] - lu[63] * b[0];
    b[2] = b[2] - lu[69] * b[0] - lu[70] * b[1];
    b[3] = b[3] - lu[75] * b[0] - lu[76] * b[1] - lu[77] * b[2];
    b[4] = b[4] - lu[81] * b[0] - lu[82] * b[1] - lu[83] * b[2] - lu[84] * b[3];
    b[5] = b[5] - lu[87] * b[0] - lu[88] * b[1] - lu[89] * b[2] - lu[90] * b[3] - lu[91] * b[4];
    b[5] = b[5] * lu[92];
    b[4] = (b[4] - lu[86] * b[5]) * lu[85];
    b[3] = (b[3] - lu[80] * b[5] - lu[79] * b[4]) * lu[78];
    b[2] = (b[2] - lu[74] * b[5] - lu[73] * b[4] - lu[72] * b[3]) * lu[71];
    b[1] = (b[1] - lu[68] * b[5] - lu[67] * b[4] - lu[66] * b[3] - lu[65] * b[2]) * lu[64];
    b[0] = (b[0] - lu[62] * b[5] - lu[61] * b[4] - lu[60] * b[3] - lu[59] * b[2] - lu[58] * b[1]) * lu[57];
    b[9] = (b[9] - lu[56] * b[5] - lu[55] * b[4] - lu[54] * b[3] - lu[53] * b[2] - lu[52] * b[1]
        - lu[51] * b[0]) * lu[50];
    b[8] = (b[8] - lu[46] * b[5] - lu[45] * b[4] - lu[44] * b[3] - lu[43] * b[2] - lu[42] * b[1]
        - lu[41] * b[0] - lu[40] * b[9]) * lu[39];
    b[7] = (b[7] - lu[36] * b[5] - lu[35] * b[4] - lu[34] * b[3] - lu[33] * b[2] - lu[32] * b[1]
        - lu[31] * b[0] - lu[30] * b[9] - lu[29] * b[8]) * lu[28];
    b[6] = (b[6] - lu[26] * b[5] - lu[25] * b[4] - lu[24] * b[3] - lu[23] * b[2] - lu[22] * b[1]
        - lu[21] * b[0] - lu[20] * b[9] - lu[19] * b[8] - lu[18] * b[7]) * lu[17];
    b[12] = (b[12] - lu[16] * b[5] - lu[15] * b[4] - lu[14] * b[3] - lu[13] * b[2] - lu[12] * b[1]
        - lu[11] * b[0] - lu[10] * b[9] - lu[9] * b[8] - lu[8] * b[7] - lu[7] * b[6]) * lu[6];
    b[11] = (b[11] - lu[5] * b[5] - lu[4] * b[4] - lu[3] * b[3] - lu[2] * b[2] - lu[1] * b[1]
        - lu[0] * b[0] - lu[-1] * b[9] - lu[-2] * b[8] - lu[-3] * b[7] - lu[-4] * b[6]) * lu[-5];
    b[10] = (b[10] - lu[-6] * b[5] - lu[-7] * b[4] - lu[-8] * b[3] - lu[-9] * b[2] - lu[-10] * b[1]
        - lu[-11] * b[0] - lu[-12] * b[9] - lu[-13] * b[8] - lu[-14] * b[7] - lu[-15] * b[6]) * lu[-16];
}

static void model_solve(const double *lu, double *b, double *w)
{
    (void)w;
    model_solve_1(lu + 16, b);
}

/* --- tables ------------------------------------------------------------------------------ */

static const bgc_param_info model_param[] = {
    {"com[1]", "m", 0.3, -INFINITY, INFINITY},
    {"com[2]", "m", -0.2, -INFINITY, INFINITY},
    {"com[3]", "m", 0.5, -INFINITY, INFINITY},
    {"inertia[1,1]", "kg*m^2", 40.0, -INFINITY, INFINITY},
    {"inertia[1,2]", "kg*m^2", 3.0, -INFINITY, INFINITY},
    {"inertia[1,3]", "kg*m^2", -2.0, -INFINITY, INFINITY},
    {"inertia[2,1]", "kg*m^2", 3.0, -INFINITY, INFINITY},
    {"inertia[2,2]", "kg*m^2", 25.0, -INFINITY, INFINITY},
    {"inertia[2,3]", "kg*m^2", 4.0, -INFINITY, INFINITY},
    {"inertia[3,1]", "kg*m^2", -2.0, -INFINITY, INFINITY},
    {"inertia[3,2]", "kg*m^2", 4.0, -INFINITY, INFINITY},
    {"inertia[3,3]", "kg*m^2", 15.0, -INFINITY, INFINITY},
    {"twist0[1]", "", 1.0, -INFINITY, INFINITY},
    {"twist0[2]", "", -2.0, -INFINITY, INFINITY},
    {"twist0[3]", "", 0.5, -INFINITY, INFINITY},
    {"twist0[4]", "", 1.5, -INFINITY, INFINITY},
    {"twist0[5]", "", -0.8, -INFINITY, INFINITY},
    {"twist0[6]", "", 2.2, -INFINITY, INFINITY},
    {"angles0[1]", "rad", 0.4, -INFINITY, INFINITY},
    {"angles0[2]", "rad", -0.3, -INFINITY, INFINITY},
    {"angles0[3]", "rad", 0.9, -INFINITY, INFINITY},
    {"pose.r0[1]", "m", 1.0, -INFINITY, INFINITY},
    {"pose.r0[2]", "m", 2.0, -INFINITY, INFINITY},
    {"pose.r0[3]", "m", 3.0, -INFINITY, INFINITY},
    {"pose.angles0[1]", "rad", 0.4, -INFINITY, INFINITY},
    {"pose.angles0[2]", "rad", -0.3, -INFINITY, INFINITY},
    {"pose.angles0[3]", "rad", 0.9, -INFINITY, INFINITY},
    {"pose.attitude.angles0[1]", "rad", 0.4, -INFINITY, INFINITY},
    {"pose.attitude.angles0[2]", "rad", -0.3, -INFINITY, INFINITY},
    {"pose.attitude.angles0[3]", "rad", 0.9, -INFINITY, INFINITY},
};

static const bgc_var_info model_state[] = {
    /* 0 */ {"free.body.p[1]", "N*s"},
    /* 1 */ {"free.body.p[2]", "N*s"},
    /* 2 */ {"free.body.p[3]", "N*s"},
    /* 3 */ {"free.body.p[4]", "N*m*s"},
    /* 4 */ {"free.body.p[5]", "N*m*s"},
    /* 5 */ {"free.body.p[6]", "N*m*s"},
    /* 6 */ {"pose.attitude.h[1]", ""},
    /* 7 */ {"pose.attitude.h[2]", ""},
    /* 8 */ {"pose.attitude.h[3]", ""},
    /* 9 */ {"pose.attitude.h[4]", ""},
    /* 10 */ {"pose.r[1]", "m"},
    /* 11 */ {"pose.r[2]", "m"},
    /* 12 */ {"pose.r[3]", "m"},
};

static const int model_watch[] = {
    2,
};

static const bgc_var_info model_output[] = {
    /* 0 */ {"linear[1]", ""},
    /* 1 */ {"linear[2]", ""},
    /* 2 */ {"linear[3]", ""},
    /* 3 */ {"angular[1]", ""},
    /* 4 */ {"angular[2]", ""},
    /* 5 */ {"angular[3]", ""},
    /* 6 */ {"momentum[1]", "N*s"},
    /* 7 */ {"momentum[2]", "N*s"},
    /* 8 */ {"momentum[3]", "N*s"},
    /* 9 */ {"momentum[4]", "N*m*s"},
    /* 10 */ {"momentum[5]", "N*m*s"},
    /* 11 */ {"momentum[6]", "N*m*s"},
    /* 12 */ {"twist[1]", "m/s"},
    /* 13 */ {"twist[2]", "m/s"},
    /* 14 */ {"twist[3]", "m/s"},
    /* 15 */ {"twist[4]", "rad/s"},
    /* 16 */ {"twist[5]", "rad/s"},
    /* 17 */ {"twist[6]", "rad/s"},
};

static const char *const model_param_check[] = {
    "the inertia of `free.body[4]` must be positive",
    "the inertia of `free.body[5]` must be positive",
    "the inertia of `free.body[6]` must be positive",
    "the matrix of `free.body` must be symmetric: its entries [4, 5] and [5, 4] differ, by `inertia[1,2]` and `inertia[2,1]`",
    "the matrix of `free.body` must be symmetric: its entries [4, 6] and [6, 4] differ, by `inertia[1,3]` and `inertia[3,1]`",
    "the matrix of `free.body` must be symmetric: its entries [5, 6] and [6, 5] differ, by `inertia[2,3]` and `inertia[3,2]`",
    "an expression of `com` and `inertia` must not be zero: the equation of `free.body.p[1]` divides by it",
    "an expression of `com` and `inertia` must not be zero: the equation of `free.body.p[1]` divides by it",
    "an expression of `com` and `inertia` must be finite, but divides by zero: the equation of `free.body.p[1]` needs it",
};

static const int model_jac_row[] = {
    0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2,
    2, 2, 3, 3, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 5, 5,
    5, 5, 5, 5, 6, 6, 6, 6, 6, 6, 6, 6, 6, 7, 7, 7,
    7, 7, 7, 7, 7, 7, 8, 8, 8, 8, 8, 8, 8, 8, 8, 9,
    9, 9, 9, 9, 9, 9, 9, 9, 10, 10, 10, 10, 10, 10, 10, 10,
    10, 10, 11, 11, 11, 11, 11, 11, 11, 11, 11, 11, 12, 12, 12, 12,
    12, 12, 12, 12, 12, 12,
};

static const int model_jac_col[] = {
    0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5, 0, 1, 2, 3,
    4, 5, 0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5, 0, 1,
    2, 3, 4, 5, 0, 1, 2, 3, 4, 5, 7, 8, 9, 0, 1, 2,
    3, 4, 5, 6, 8, 9, 0, 1, 2, 3, 4, 5, 6, 7, 9, 0,
    1, 2, 3, 4, 5, 6, 7, 8, 0, 1, 2, 3, 4, 5, 6, 7,
    8, 9, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 0, 1, 2, 3,
    4, 5, 6, 7, 8, 9,
};

static const int model_pivot_row[] = {
    10, 11, 12, 6, 7, 8, 9, 0, 1, 2, 3, 4, 5,
};

static const int model_pivot_col[] = {
    10, 11, 12, 6, 7, 8, 9, 0, 1, 2, 3, 4, 5,
};

static const int model_lu_row[] = {
    0, 11, 22, 33, 43, 53, 63, 73, 79, 85, 91, 97, 103, 109,
};

static const int model_lu_pivot[] = {
    0, 11, 22, 33, 44, 55, 66, 73, 80, 87, 94, 101, 108,
};

static const int model_lu_col[] = {
    0, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 1, 3, 4, 5, 6,
    7, 8, 9, 10, 11, 12, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11,
    12, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 3, 4, 5, 6, 7,
    8, 9, 10, 11, 12, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 3,
    4, 5, 6, 7, 8, 9, 10, 11, 12, 7, 8, 9, 10, 11, 12, 7,
    8, 9, 10, 11, 12, 7, 8, 9, 10, 11, 12, 7, 8, 9, 10, 11,
    12, 7, 8, 9, 10, 11, 12, 7, 8, 9, 10, 11, 12,
};

static const int model_lu_jac[] = {
    73, 74, 75, 76, 77, 78, 79, 80, 81, 82, 83, 84, 85, 86, 87, 88,
    89, 90, 91, 92, 93, 94, 95, 96, 97, 98, 99, 100, 101, 102, 103, 104,
    105, 106, 107, 108, 37, 38, 39, 40, 41, 42, 34, 35, 36, 47, 48, 49,
    50, 51, 52, 43, 45, 46, 57, 58, 59, 60, 61, 62, 53, 54, 56, 67,
    68, 69, 70, 71, 72, 63, 64, 65, 5, 6, 7, 8, 9, 10, 1, 2,
    3, 4, 16, 17, 18, 19, 20, 21, 12, 13, 14, 15, 27, 28, 29, 30,
    31, 32, 23, 24, 25, 26,
};

static const bgc_model model_info = {
    .abi = BGC_ABI,
    .name = "quaternion",
    .hash = "of its sources",
    .n_param = 30,
    .n_hoist = 64,
    .n_state = 13,
    .n_input = 0,
    .n_output = 18,
    .n_command = 0,
    .n_assert = 0,
    .n_device = 0,
    .n_jac = 102,
    .n_mass = 0,
    .n_lu = 109,
    .n_check = 9,
    .n_switch = 0,
    .n_timed = 0,
    .param = model_param,
    .state = model_state,
    .switch_info = NULL,
    .watch = model_watch,
    .n_watch = 1,
    .output = model_output,
    .input = NULL,
    .command = NULL,
    .device = NULL,
    .assertion = NULL,
    .param_check = model_param_check,
    .jac_row = model_jac_row,
    .jac_col = model_jac_col,
    .mass_row = NULL,
    .mass_col = NULL,
    .pivot_row = model_pivot_row,
    .pivot_col = model_pivot_col,
    .lu_row = model_lu_row,
    .lu_pivot = model_lu_pivot,
    .lu_col = model_lu_col,
    .lu_jac = model_lu_jac,
    .lu_mass = NULL,
    .step = 0.0,
    .duration = 10.0,
    .every = 0.1,
    .n_work = 53,
    .prepare = model_prepare,
    .rhs = model_rhs,
    .jacobian = model_jacobian,
    .energy = model_energy,
    .outputs = model_outputs,
    .commands = model_commands,
    .asserts = model_asserts,
    .project = model_project,
    .mass = model_mass,
    .initial = model_initial,
    .scale = model_scale,
    .positive = model_positive,
    .watched = model_watched,
    .defaults = model_defaults,
    .factor = model_factor,
    .solve = model_solve,
    .explicit_cost = 0.58,
};

const bgc_model *bgc_get_model(void)
{
    return &model_info;
}
