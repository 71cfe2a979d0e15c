/* The soil model "none": an object only compacts soil. The soil that it displaces is lost (dissertation 4.4.2). */
#include "deform/internal.h"

static enum status batch(struct deform *deform)
{
	TRY(deform_batch_contact(deform));
	return deform_batch_store(deform);
}

const struct soil_model deform_model_none = {
	.name = "none",
	.use = "takes the imprint",
	.volume = "compacted",
	.effect = {
		"displace", "objects", "", EFFECT_LIST("deform/under.frag", "deform/none.frag", "deform/gather.frag", "deform/store.frag"),
		"base, offset", "offset", 0,
		EFFECT_LIST("objects[].shape.wheel.radius", "objects[].shape.wheel.width", "objects[].shape.sphere.radius",
			    "objects[].shape.box.size[]", "objects[].shape.cylinder.radius",
			    "objects[].shape.cylinder.length", "objects[].shape.capsule.radius", "objects[].shape.capsule.length",
			    "objects[].shape.ellipsoid.radii[]", "objects[].sink", "redistribute.regions"),
		"a window is at most 256 x 256 posts, a sweep at most 16 of them; an object at most 672 posts across, and "
		"512 m; an offset at most 1024 m",
		"lowers the ground to what presses it, no more"},
	.touched_effect = "dirt",
	.keys = EFFECT_LIST("regions"),
	.contact = deform_contact_plainly,
	.batch = batch,
	.shader = "deform/none.frag",
	.blind = true,
};
