/* The parts of an input of the target for scenes (scene.c says what they are). */
#ifndef FURROW_FUZZ_SCENE_H
#define FURROW_FUZZ_SCENE_H

#include <unistd.h>

#include "fuzz.h"

#define SCENE_POSES "%poses\n"
#define SCENE_SET "%set\n"

#endif
