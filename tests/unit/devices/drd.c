/* drd.c: stands in for libdrd of the Force Dimension SDK: an omega.7 whose hand moves as the test says. */
#include <math.h>
#include <stdio.h>
#include <string.h>

typedef unsigned char byte;

int drd_type = 35, drd_left, drd_answer, drd_initialised, drd_calibration, drd_present = 1;
double drd_force[7], drd_position[3], drd_turn; /* drd_turn: rad, about z */
char drd_calls[4000];

static void note(const char *name) {
    if (strlen(drd_calls) < 3900) {
        strcat(strcat(drd_calls, name), " ");
    }
}

int drdOpen(void) {
    note("drdOpen");
    return drd_present ? 0 : -1;
}

int drdOpenID(char id) {
    note("drdOpenID");
    return drd_present ? id : -1;
}

byte drdIsInitialized(char id) { return (void)id, (byte)drd_initialised; }

#ifndef WITHOUT_AUTO_INIT
int drdAutoInit(char id) {
    (void)id;
    note("drdAutoInit");
    return drd_calibration;
}
#endif

int drdStop(byte force, char id) {
    (void)id;
    note(force ? "drdStop(true)" : "drdStop(false)");
    return 0;
}

int dhdClose(char id) {
    (void)id;
    note("dhdClose");
    return 0;
}

int dhdStop(char id) {
    (void)id;
    note("dhdStop");
    return 0;
}

int dhdErrorGetLast(void) { return 5; }
const char *dhdErrorGetLastStr(void) { return "no device found"; }
int dhdGetSystemType(char id) { return (void)id, drd_type; }
byte dhdHasBase(char id) { return (void)id, 1; }
byte dhdHasWrist(char id) { return (void)id, drd_type != 33; }
byte dhdHasActiveWrist(char id) { return (void)id, drd_type >= 104; }
byte dhdHasGripper(char id) { return (void)id, drd_type != 33; }
byte dhdHasActiveGripper(char id) { return (void)id, drd_type != 33; }
byte dhdIsLeftHanded(char id) { return (void)id, (byte)drd_left; }

int dhdEnableForce(byte on, char id) {
    (void)id;
    note(on ? "dhdEnableForce(1)" : "dhdEnableForce(0)");
    return 0;
}

int dhdSetGravityCompensation(int on, char id) { return (void)id, (void)on, 0; }

int dhdGetPosition(double *x, double *y, double *z, char id) {
    (void)id;
    *x = drd_position[0];
    *y = drd_position[1];
    *z = drd_position[2];
    return drd_answer;
}

int dhdGetOrientationFrame(double r[3][3], char id) {
    const double c = cos(drd_turn), s = sin(drd_turn);
    const double turned[3][3] = {{c, -s, 0}, {s, c, 0}, {0, 0, 1}};

    (void)id;
    memcpy(r, turned, sizeof turned);
    return 0;
}

int dhdGetGripperGap(double *gap, char id) {
    (void)id;
    *gap = 0.012;
    return 1;
}

int dhdGetButton(int index, char id) { return (void)id, index == 2; }

int dhdSetForceAndTorqueAndGripperForce(double x, double y, double z, double a, double b, double c,
                                        double gripper, char id) {
    const double all[7] = {x, y, z, a, b, c, gripper};

    (void)id;
    memcpy(drd_force, all, sizeof all);
    return drd_answer;
}
