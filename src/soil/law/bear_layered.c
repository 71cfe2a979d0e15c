/* bear.c for ground whose soil lies over another: layers.h. */
#define SOIL_LAYERED 1
#undef soil_bear /* a test gives it another name */
#define soil_bear soil_bear_layered
#include "soil/law/bear.c"
