#include "pointbake/texture.h"
