#include "pointbake/patch.h"
