/*
 * What a URDF shows: its <visual>s, which MuJoCo leaves out, with their colours. Also the links that are fixed to others, since MuJoCo makes one body of them.
 *
 * The text must have passed vehicle_check_model: it is whole, and has a bounded number of elements.
 */
#ifndef FURROW_VEHICLE_URDF_H
#define FURROW_VEHICLE_URDF_H

#include "base/base.h"

/* A place in the axes of a link: metres, and its axes as columns. */
struct urdf_place {
	double at[3], axes[9];
};

enum urdf_form { URDF_NONE, URDF_BOX, URDF_CYLINDER, URDF_SPHERE, URDF_CAPSULE, URDF_MESH };

struct urdf_visual {
	size_t link;
	struct urdf_place place;
	enum urdf_form form;
	double size[3];   /* m: box: its sides; cylinder, capsule: radius, length; sphere: radius. Mesh: scale along each axis */
	char *file;       /* of a mesh, as it is written; owned */
	char *material;   /* owned; NULL: none */
	float colour[4];  /* sRGB and alpha */
	bool coloured, textured; /* textured: its material has a file of colours, which is not read */
};

struct urdf_link {
	char *name;       /* owned */
	size_t parent;    /* of the joint that fixes it; SIZE_MAX: it moves, or is the root */
	struct urdf_place place; /* against that parent */
};

struct urdf {
	bool is;          /* the file is a URDF */
	char *meshdir;    /* owned; NULL: none */
	struct urdf_link *links;
	struct urdf_visual *visuals;
	size_t link_count, link_room, visual_count, visual_room;
};

/* Reads a model's file. Of an MJCF it leaves `is` false, and the rest empty. Finish it also after a failure. STATUS_INPUT: the file cannot be read. */
enum status vehicle_urdf_read(const char *where, const char *path, struct urdf *out) FURROW_CHECKED;
void vehicle_urdf_finish(struct urdf *urdf);
/* Computes `outer` after `inner`. */
void vehicle_urdf_join(const struct urdf_place *outer, const struct urdf_place *inner, struct urdf_place *out);

#endif
