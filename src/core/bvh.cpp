#include "core/bvh.h"
