// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Stands in for OpenHaptics' HD/hd.h, so that openhaptics_device.cpp can be compiled and tested
/// without it: those names that it uses, with what the vendor's published manual says of them. The
/// numbers are ours. devices/stubs/hd.cpp has a simulated device behind them.

using HDenum = unsigned int;
using HDerror = unsigned int;
using HDint = int;
using HDushort = unsigned short;
using HDdouble = double;
using HDstring = const char*;
using HHD = unsigned int;
using HDSchedulerHandle = unsigned long;
using HDCallbackCode = unsigned int;

#define HDCALLBACK
using HDSchedulerCallback = HDCallbackCode(HDCALLBACK*)(void*);

struct HDErrorInfo {
  HDerror errorCode;
  int internalErrorCode;
  HHD hHD;
};
#define HD_DEVICE_ERROR(info) ((info).errorCode != HD_SUCCESS)

enum : HDerror {
  HD_SUCCESS,
  // the force is dropped, the device is well
  HD_WARM_MOTORS,
  HD_EXCEEDED_MAX_FORCE,
  HD_EXCEEDED_MAX_FORCE_IMPULSE,
  HD_EXCEEDED_MAX_VELOCITY,
  HD_FORCE_ERROR,
  // it is not
  HD_DEVICE_FAULT,
  HD_COMM_ERROR,
};

enum : HHD { HD_INVALID_HANDLE = 0xffffffff };
enum : HDCallbackCode { HD_CALLBACK_DONE, HD_CALLBACK_CONTINUE };
enum : HDushort { HD_MAX_SCHEDULER_PRIORITY = 0xffff };
enum : HDenum { HD_FORCE_OUTPUT = 1 };
enum : HDenum { HD_CALIBRATION_OK, HD_CALIBRATION_NEEDS_UPDATE, HD_CALIBRATION_NEEDS_MANUAL_INPUT };
/// Ways to calibrate, a bit each.
enum : HDenum {
  HD_CALIBRATION_ENCODER_RESET = 1,
  HD_CALIBRATION_AUTO = 2,
  HD_CALIBRATION_INKWELL = 4
};
enum : HDenum {
  HD_CURRENT_BUTTONS,
  HD_CURRENT_TRANSFORM,  // 16 numbers, columns one after another [mm]
  HD_CURRENT_FORCE,      // [N]
  HD_CALIBRATION_STYLE,
};

inline constexpr HDstring HD_DEFAULT_DEVICE = nullptr;

HHD hdInitDevice(HDstring name);
void hdDisableDevice(HHD device);
void hdEnable(HDenum capability);

HDSchedulerHandle hdScheduleAsynchronous(HDSchedulerCallback callback, void* data,
                                         HDushort priority);
void hdStartScheduler();
void hdStopScheduler();

void hdBeginFrame(HHD device);
void hdEndFrame(HHD device);
void hdGetDoublev(HDenum name, HDdouble* values);
void hdGetIntegerv(HDenum name, HDint* values);
void hdSetDoublev(HDenum name, const HDdouble* values);

HDenum hdCheckCalibration();
void hdUpdateCalibration(HDenum style);

/// The newest error, which it takes off a stack.
HDErrorInfo hdGetError();
HDstring hdGetErrorString(HDerror error);
