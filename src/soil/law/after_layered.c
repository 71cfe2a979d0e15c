/* after.c for ground whose soil lies over another: layers.h. */
#define SOIL_LAYERED 1
#undef soil_after /* a test gives it another name */
#define soil_after soil_after_layered
#include "soil/law/after.c"
