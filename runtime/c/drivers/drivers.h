/* drivers.h: the drivers of devices, one line each. Each is defined in a file of this folder; its
 * functions are described at bgc_driver in bgc_device.h. */
#ifndef BGC_DRIVERS_H
#define BGC_DRIVERS_H

#ifndef BGC_DRIVERS /* a program without sockets or libraries has fewer */
#define BGC_DRIVERS(DRIVER) \
    DRIVER(bgc_forcedimension_driver) \
    DRIVER(bgc_gamepad_driver) \
    DRIVER(bgc_haply_driver) \
    DRIVER(bgc_pointer_driver) \
    DRIVER(bgc_spring_hand_driver) \
    DRIVER(bgc_trace_driver) \
    DRIVER(bgc_udp_driver)
#endif

#endif
