#include "core/mapped_file.h"
