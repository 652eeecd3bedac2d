#include "core/kdtree.h"
