#include "vehicle/urdf.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vehicle/check.h"
#include "vehicle/xml.h"

static const struct urdf_place same = {{0, 0, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};

/* A material of the file, or a joint: known once all of it was read. */
struct material {
	char *name;
	float colour[4];
	bool coloured, textured;
};

struct joint {
	char *parent, *child;
	bool fixed;
	struct urdf_place place;
};

struct reading {
	struct urdf *urdf;
	struct material *materials;
	struct joint *joints;
	size_t material_count, material_room, joint_count, joint_room;
	/* What is open; depth 0: it is not. */
	int link, visual, material, joint;
};

/* --- attributes --- */

static enum status copy(const struct vehicle_xml_attribute *from, char **to)
{
	if (*to != NULL)
		return STATUS_OK;
	TRY(mem_make(to, from->value_length + 1, 1, "a vehicle"));
	memcpy(*to, from->value, from->value_length);
	(*to)[from->value_length] = '\0';
	return STATUS_OK;
}

/* Reads up to `count` numbers. Others keep what they are. */
static void numbers(const struct vehicle_xml_attribute *from, double *to, int count)
{
	char text[128], *at = text, *end;
	snprintf(text, sizeof text, "%.*s", (int)(from->value_length < 127 ? from->value_length : 127), from->value);
	for (int i = 0; i < count; i++, at = end) {
		const double number = strtod(at, &end);
		if (end == at || !isfinite(number))
			return;
		to[i] = number;
	}
}

static bool is(const struct vehicle_xml *xml, const char *name)
{
	return vehicle_xml_is(xml->name, xml->name_length, name);
}

static bool named(const struct vehicle_xml_attribute *attribute, const char *name)
{
	return vehicle_xml_is(attribute->name, attribute->name_length, name);
}

/* Turns about the fixed axes x, y, z, in this order. */
static void turn(const double angles[3], double axes[9])
{
	const double cr = cos(angles[0]), sr = sin(angles[0]), cp = cos(angles[1]), sp = sin(angles[1]), cy = cos(angles[2]), sy = sin(angles[2]);
	const double turned[9] = {cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr, -sp, cp * sr, cp * cr};
	memcpy(axes, turned, sizeof turned);
}

void vehicle_urdf_join(const struct urdf_place *outer, const struct urdf_place *inner, struct urdf_place *out)
{
	struct urdf_place joined;
	for (int i = 0; i < 3; i++) {
		joined.at[i] = outer->at[i];
		for (int k = 0; k < 3; k++) {
			joined.at[i] += outer->axes[3 * i + k] * inner->at[k];
			joined.axes[3 * i + k] = 0;
			for (int j = 0; j < 3; j++)
				joined.axes[3 * i + k] += outer->axes[3 * i + j] * inner->axes[3 * j + k];
		}
	}
	*out = joined;
}

/* --- elements --- */

static struct urdf_visual *visual_of(const struct reading *reading)
{
	return reading->visual > 0 ? &reading->urdf->visuals[reading->urdf->visual_count - 1] : NULL;
}

static enum status open_link(struct reading *reading, struct vehicle_xml *xml)
{
	struct urdf *urdf = reading->urdf;
	struct vehicle_xml_attribute attribute;
	TRY(mem_grow(&urdf->links, &urdf->link_room, urdf->link_count + 1, sizeof *urdf->links, "a vehicle"));
	struct urdf_link *link = &urdf->links[urdf->link_count++];
	*link = (struct urdf_link){.parent = SIZE_MAX, .place = same};
	reading->link = xml->depth;
	while (vehicle_xml_attribute(xml, &attribute))
		if (named(&attribute, "name"))
			TRY(copy(&attribute, &link->name));
	return STATUS_OK;
}

static enum status open_visual(struct reading *reading, const struct vehicle_xml *xml)
{
	struct urdf *urdf = reading->urdf;
	TRY(mem_grow(&urdf->visuals, &urdf->visual_room, urdf->visual_count + 1, sizeof *urdf->visuals, "a vehicle"));
	urdf->visuals[urdf->visual_count++] = (struct urdf_visual){.link = urdf->link_count - 1, .place = same};
	reading->visual = xml->depth;
	return STATUS_OK;
}

static enum status open_joint(struct reading *reading, struct vehicle_xml *xml)
{
	struct vehicle_xml_attribute attribute;
	TRY(mem_grow(&reading->joints, &reading->joint_room, reading->joint_count + 1, sizeof *reading->joints, "a vehicle"));
	struct joint *joint = &reading->joints[reading->joint_count++];
	*joint = (struct joint){.place = same};
	reading->joint = xml->depth;
	while (vehicle_xml_attribute(xml, &attribute))
		joint->fixed |= named(&attribute, "type") && vehicle_xml_is(attribute.value, attribute.value_length, "fixed");
	return STATUS_OK;
}

static enum status open_material(struct reading *reading, struct vehicle_xml *xml)
{
	struct vehicle_xml_attribute attribute;
	struct urdf_visual *visual = visual_of(reading);
	TRY(mem_grow(&reading->materials, &reading->material_room, reading->material_count + 1, sizeof *reading->materials, "a vehicle"));
	struct material *material = &reading->materials[reading->material_count++];
	*material = (struct material){.name = NULL};
	reading->material = xml->depth;
	while (vehicle_xml_attribute(xml, &attribute)) {
		if (!named(&attribute, "name"))
			continue;
		TRY(copy(&attribute, &material->name));
		if (visual != NULL)
			TRY(copy(&attribute, &visual->material));
	}
	return STATUS_OK;
}

static void take_colour(const struct reading *reading, struct vehicle_xml *xml)
{
	struct material *material = &reading->materials[reading->material_count - 1];
	struct urdf_visual *visual = visual_of(reading);
	struct vehicle_xml_attribute attribute;
	double rgba[4] = {0.5, 0.5, 0.5, 1};
	while (vehicle_xml_attribute(xml, &attribute)) {
		if (!named(&attribute, "rgba"))
			continue;
		numbers(&attribute, rgba, 4);
		for (int k = 0; k < 4; k++)
			material->colour[k] = (float)fmin(fmax(rgba[k], 0), 1);
		material->coloured = true;
	}
	if (visual == NULL || !material->coloured)
		return;
	memcpy(visual->colour, material->colour, sizeof visual->colour);
	visual->coloured = true;
}

static void take_origin(struct vehicle_xml *xml, struct urdf_place *place)
{
	struct vehicle_xml_attribute attribute;
	double angles[3] = {0, 0, 0};
	while (vehicle_xml_attribute(xml, &attribute)) {
		if (named(&attribute, "xyz"))
			numbers(&attribute, place->at, 3);
		else if (named(&attribute, "rpy"))
			numbers(&attribute, angles, 3);
	}
	turn(angles, place->axes);
}

static enum status take_form(struct urdf_visual *visual, struct vehicle_xml *xml, enum urdf_form form)
{
	struct vehicle_xml_attribute attribute;
	visual->form = form;
	for (int k = 0; k < 3; k++)
		visual->size[k] = form == URDF_MESH ? 1 : 0;
	while (vehicle_xml_attribute(xml, &attribute)) {
		if (named(&attribute, "filename"))
			TRY(copy(&attribute, &visual->file));
		else if (named(&attribute, "size") || named(&attribute, "scale"))
			numbers(&attribute, visual->size, 3);
		else if (named(&attribute, "radius"))
			numbers(&attribute, &visual->size[0], 1);
		else if (named(&attribute, "length"))
			numbers(&attribute, &visual->size[1], 1);
	}
	return STATUS_OK;
}

static enum status take_end(struct vehicle_xml *xml, char **name)
{
	struct vehicle_xml_attribute attribute;
	while (vehicle_xml_attribute(xml, &attribute))
		if (named(&attribute, "link"))
			TRY(copy(&attribute, name));
	return STATUS_OK;
}

static enum status take_of_joint(struct reading *reading, struct vehicle_xml *xml)
{
	struct joint *joint = &reading->joints[reading->joint_count - 1];
	if (is(xml, "origin"))
		take_origin(xml, &joint->place);
	if (is(xml, "parent"))
		return take_end(xml, &joint->parent);
	return is(xml, "child") ? take_end(xml, &joint->child) : STATUS_OK;
}

static enum status take_of_visual(struct reading *reading, struct vehicle_xml *xml)
{
	static const char *const forms[] = {[URDF_BOX] = "box", [URDF_CYLINDER] = "cylinder", [URDF_SPHERE] = "sphere", [URDF_CAPSULE] = "capsule", [URDF_MESH] = "mesh"};
	struct urdf_visual *visual = visual_of(reading);
	if (is(xml, "origin") && xml->depth == reading->visual + 1)
		take_origin(xml, &visual->place);
	for (int form = URDF_BOX; form <= URDF_MESH; form++)
		if (is(xml, forms[form]))
			TRY(take_form(visual, xml, (enum urdf_form)form));
	return STATUS_OK;
}

static enum status take_meshdir(struct urdf *urdf, struct vehicle_xml *xml)
{
	struct vehicle_xml_attribute attribute;
	while (vehicle_xml_attribute(xml, &attribute))
		if (named(&attribute, "meshdir"))
			TRY(copy(&attribute, &urdf->meshdir));
	return STATUS_OK;
}

static enum status take(struct reading *reading, struct vehicle_xml *xml)
{
	if (is(xml, "link") && xml->depth == 2)
		return open_link(reading, xml);
	if (is(xml, "joint") && xml->depth == 2)
		return open_joint(reading, xml);
	if (reading->link > 0 && is(xml, "visual"))
		return open_visual(reading, xml);
	if (is(xml, "material") && (xml->depth == 2 || reading->visual > 0))
		return open_material(reading, xml);
	if (reading->material > 0 && is(xml, "color"))
		take_colour(reading, xml);
	if (reading->material > 0 && is(xml, "texture"))
		reading->materials[reading->material_count - 1].textured = true;
	if (is(xml, "compiler"))
		return take_meshdir(reading->urdf, xml);
	if (reading->joint > 0)
		return take_of_joint(reading, xml);
	return reading->visual > 0 ? take_of_visual(reading, xml) : STATUS_OK;
}

static void leave(struct reading *reading, int depth)
{
	int *const open[] = {&reading->link, &reading->visual, &reading->material, &reading->joint};
	for (size_t i = 0; i < sizeof open / sizeof *open; i++)
		if (*open[i] > depth)
			*open[i] = 0;
}

/* --- once all was read --- */

static size_t link_at(const struct urdf *urdf, const char *name)
{
	for (size_t i = 0; i < urdf->link_count && name != NULL; i++)
		if (urdf->links[i].name != NULL && strcmp(urdf->links[i].name, name) == 0)
			return i;
	return SIZE_MAX;
}

/* A visual may name a material of another place in the file. */
static void find_materials(const struct reading *reading)
{
	for (size_t v = 0; v < reading->urdf->visual_count; v++) {
		struct urdf_visual *visual = &reading->urdf->visuals[v];
		for (size_t i = 0; i < reading->material_count && visual->material != NULL; i++) {
			const struct material *material = &reading->materials[i];
			if (material->name == NULL || strcmp(material->name, visual->material) != 0)
				continue;
			visual->textured |= material->textured;
			if (visual->coloured || !material->coloured)
				continue;
			memcpy(visual->colour, material->colour, sizeof visual->colour);
			visual->coloured = true;
		}
	}
}

static void fix_links(const struct reading *reading)
{
	for (size_t i = 0; i < reading->joint_count; i++) {
		const struct joint *joint = &reading->joints[i];
		const size_t child = link_at(reading->urdf, joint->child), parent = link_at(reading->urdf, joint->parent);
		if (!joint->fixed || child == SIZE_MAX || parent == SIZE_MAX)
			continue;
		reading->urdf->links[child].parent = parent;
		reading->urdf->links[child].place = joint->place;
	}
}

static enum status read_text(struct reading *reading, const char *text, size_t length)
{
	struct vehicle_xml xml = vehicle_xml_begin(text, length);
	enum vehicle_xml_event event;
	while ((event = vehicle_xml_next(&xml)) == VEHICLE_XML_OPEN || event == VEHICLE_XML_CLOSE) {
		if (event == VEHICLE_XML_CLOSE) {
			leave(reading, xml.depth);
			continue;
		}
		if (xml.depth == 1 && !is(&xml, "robot"))
			return STATUS_OK;
		reading->urdf->is = true;
		TRY(take(reading, &xml));
	}
	find_materials(reading);
	fix_links(reading);
	return STATUS_OK;
}

enum status vehicle_urdf_read(const char *where, const char *path, struct urdf *out)
{
	struct vehicle_check check = {.where = where, .path = path};
	struct reading reading = {.urdf = out};
	char *text;
	size_t length;
	*out = (struct urdf){.is = false};
	TRY(vehicle_check_read(&check, path, &text, &length));
	const enum status status = read_text(&reading, text, length);
	for (size_t i = 0; i < reading.material_count; i++)
		mem_free(reading.materials[i].name);
	for (size_t i = 0; i < reading.joint_count; i++)
		mem_free_all(reading.joints[i].parent, reading.joints[i].child);
	mem_free_all(reading.materials, reading.joints, text);
	return status;
}

void vehicle_urdf_finish(struct urdf *urdf)
{
	for (size_t i = 0; i < urdf->link_count; i++)
		mem_free(urdf->links[i].name);
	for (size_t i = 0; i < urdf->visual_count; i++)
		mem_free_all(urdf->visuals[i].file, urdf->visuals[i].material);
	mem_free_all(urdf->links, urdf->visuals, urdf->meshdir);
}
