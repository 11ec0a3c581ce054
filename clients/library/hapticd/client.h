// SPDX-License-Identifier: Apache-2.0
#pragma once

// what programs outside of this tree include
#include "clients/library/client.h"
#include "clients/library/drawer.h"
#include "clients/library/giver.h"
