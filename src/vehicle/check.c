/*
 * What a model asks for, by its text. MuJoCo takes memory for the numbers of `size`, `hfield`, `texture` and others as they are
 * written, however small the file. It also makes lists that grow with the square of constraints and degrees of freedom.
 *
 * The limits are far above what a vehicle needs. All are named in VEHICLES.md.
 */
#include "vehicle/check.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vehicle/xml.h"

#define DEPTH_MOST 100
#define ELEMENTS_MOST 20000
#define BODIES_MOST 10000
#define KEYS_MOST 1000
#define FREEDOMS_MOST 3000
#define BYTES_MOST (256.0 * 1024 * 1024)
#define INCLUDES_MOST 100

/* An attribute whose number is limited. */
static const struct limit {
	const char *element, *attribute; /* element NULL: of each */
	double most;
} limits[] = {
	{"size", "njmax", 5000},
	{"size", "nconmax", 100000},
	{"size", "nstack", 1 << 25},
	{"size", "nuserdata", 1000000},
	{"size", "nkey", KEYS_MOST},
	{"size", "nuser_body", 1000},
	{"size", "nuser_jnt", 1000},
	{"size", "nuser_geom", 1000},
	{"size", "nuser_site", 1000},
	{"size", "nuser_cam", 1000},
	{"size", "nuser_tendon", 1000},
	{"size", "nuser_actuator", 1000},
	{"size", "nuser_sensor", 1000},
	{"hfield", "nrow", 65536},
	{"hfield", "ncol", 65536},
	{"texture", "width", 65536},
	{"texture", "height", 65536 * 6},
	{"numeric", "size", 1000000},
	{"option", "iterations", 10000},
	{"option", "noslip_iterations", 10000},
	{"option", "mpr_iterations", 10000},
	{"compiler", "maxhullvert", 1000000},
};

static enum status refuse(const struct vehicle_check *check, const char *what, double asked, double most)
{
	return fail_with(STATUS_INPUT, "%s: %s: %s: %.10g is too much; allowed: %.10g; lower it", check->where, check->path, what, asked, most);
}

/* Reads the numbers of a value. Returns how many; a text that is no number ends them. */
static size_t numbers_of(const struct vehicle_xml_attribute *attribute, double *out, size_t room)
{
	char text[256], *at = text, *end;
	size_t count = 0;
	snprintf(text, sizeof text, "%.*s", (int)(attribute->value_length < 255 ? attribute->value_length : 255), attribute->value);
	for (; count < room; at = end) {
		const double number = strtod(at, &end);
		if (end == at)
			break;
		out[count++] = number;
	}
	return count;
}

/* "1G" and the like: bytes. */
static double memory_of(const struct vehicle_xml_attribute *attribute)
{
	static const char units[] = "KMGTPE";
	double number = 0;
	const char last = attribute->value_length > 0 ? attribute->value[attribute->value_length - 1] : '0';
	const char *unit = last != '\0' ? strchr(units, last & ~0x20) : NULL;
	(void)numbers_of(attribute, &number, 1);
	return unit != NULL ? ldexp(number, 10 * (int)(unit - units + 1)) : number;
}

static enum status check_limits(const struct vehicle_check *check, const struct vehicle_xml *xml, const struct vehicle_xml_attribute *attribute)
{
	double number;
	char what[64];
	for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
		const struct limit *limit = &limits[i];
		if (!vehicle_xml_is(xml->name, xml->name_length, limit->element) || !vehicle_xml_is(attribute->name, attribute->name_length, limit->attribute))
			continue;
		snprintf(what, sizeof what, "%s of %s", limit->attribute, limit->element);
		if (memchr(attribute->value, '&', attribute->value_length) != NULL)
			return refuse(check, what, (double)NAN, limit->most);
		if (numbers_of(attribute, &number, 1) == 1 && !(number <= limit->most))
			return refuse(check, what, number, limit->most);
	}
	if (vehicle_xml_is(xml->name, xml->name_length, "size") && vehicle_xml_is(attribute->name, attribute->name_length, "memory") &&
	    !(memory_of(attribute) <= 4 * BYTES_MOST))
		return refuse(check, "memory of size", memory_of(attribute), 4 * BYTES_MOST);
	return STATUS_OK;
}

/* --- files --- */

static bool names_file(const struct vehicle_xml_attribute *attribute)
{
	return (attribute->name_length >= 4 && memcmp(attribute->name, "file", 4) == 0);
}

static enum status take_names(struct vehicle_check *check, const struct vehicle_xml *xml, const struct vehicle_xml_attribute *attribute)
{
	static const char *const folders[] = {"meshdir", "texturedir", "assetdir"};
	const bool include = vehicle_xml_is(xml->name, xml->name_length, "include");
	if (check->urdf && vehicle_xml_is(xml->name, xml->name_length, "mesh"))
		return STATUS_OK; /* spec_meshes.c looks for them */
	if (vehicle_xml_is(xml->name, xml->name_length, "skin"))
		return STATUS_OK; /* spec_parts.c takes skins out before a file is read */
	if (names_file(attribute))
		return vehicle_check_name_add(check, attribute->value, attribute->value_length, include);
	for (size_t i = 0; i < sizeof folders / sizeof folders[0]; i++)
		if (vehicle_xml_is(attribute->name, attribute->name_length, folders[i]))
			return vehicle_check_folder_add(check, attribute->value, attribute->value_length);
	return STATUS_OK;
}

/* --- what elements take --- */

struct element {
	double rows, columns, width, height, size, count;
	double freedoms; /* of a joint; 0: it says no type */
	size_t vertices; /* of a mesh in the text */
	struct vehicle_xml_attribute face; /* value NULL: it has none */
};

static size_t count_numbers(const struct vehicle_xml_attribute *attribute)
{
	size_t count = 0;
	bool word = false;
	for (size_t i = 0; i < attribute->value_length; i++) {
		const char c = attribute->value[i];
		const bool space = c == ' ' || c == '\t' || c == '\n' || c == '\r';
		count += !space && !word;
		word = !space;
	}
	return count;
}

static void take_number(struct element *element, const struct vehicle_xml_attribute *attribute)
{
	if (vehicle_xml_is(attribute->name, attribute->name_length, "vertex"))
		element->vertices = count_numbers(attribute) / 3;
	if (vehicle_xml_is(attribute->name, attribute->name_length, "face"))
		element->face = *attribute;
	const struct {
		const char *name;
		double *number;
	} known[] = {{"nrow", &element->rows}, {"ncol", &element->columns}, {"width", &element->width}, {"height", &element->height},
		     {"size", &element->size}};
	double numbers[3] = {0, 0, 0};
	const size_t count = numbers_of(attribute, numbers, 3);
	for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
		if (count > 0 && vehicle_xml_is(attribute->name, attribute->name_length, known[i].name))
			*known[i].number = fmax(numbers[0], 0);
	if (count > 0 && vehicle_xml_is(attribute->name, attribute->name_length, "count"))
		for (size_t i = 0; i < count; i++)
			element->count = (i == 0 ? 1 : element->count) * fmax(numbers[i], 1);
	if (vehicle_xml_is(attribute->name, attribute->name_length, "type"))
		element->freedoms = vehicle_xml_is(attribute->value, attribute->value_length, "free")	     ? 6
				    : vehicle_xml_is(attribute->value, attribute->value_length, "floating") ? 6
				    : vehicle_xml_is(attribute->value, attribute->value_length, "ball")	     ? 3
													     : 1;
}

/* Adds an element whose attributes were read. `in_default`: it only says what other elements are. */
static enum status add_element(struct vehicle_check *check, const struct vehicle_xml *xml, const struct element *element, bool in_default)
{
	if (element->face.value != NULL && !vehicle_check_faces(element->face.value, element->face.value_length, element->vertices))
		return fail_with(STATUS_INPUT, "%s: %s: a face of a mesh in its text names a vertex that is not there; export the model again", check->where,
				 check->path);
	const bool joint = vehicle_xml_is(xml->name, xml->name_length, "joint"), composite = vehicle_xml_is(xml->name, xml->name_length, "composite");
	if (joint && in_default)
		check->heaviest = fmax(check->heaviest, element->freedoms);
	else if (joint && element->freedoms > 0)
		check->freedoms += element->freedoms;
	else if (joint)
		check->joints++;
	if (vehicle_xml_is(xml->name, xml->name_length, "freejoint"))
		check->freedoms += 6;
	if (composite)
		check->freedoms += 3 * element->count;
	check->bodies += vehicle_xml_is(xml->name, xml->name_length, "body") || vehicle_xml_is(xml->name, xml->name_length, "link");
	check->keys += vehicle_xml_is(xml->name, xml->name_length, "key");
	if (vehicle_xml_is(xml->name, xml->name_length, "hfield"))
		check->bytes += 8 * element->rows * element->columns;
	if (vehicle_xml_is(xml->name, xml->name_length, "texture")) /* of a cube, unless it says another type */
		check->bytes += 3 * element->width * fmax(element->height, 6 * element->width);
	if (vehicle_xml_is(xml->name, xml->name_length, "numeric"))
		check->bytes += 8 * element->size;
	check->elements++;
	if (check->elements > ELEMENTS_MOST)
		return refuse(check, "elements", (double)check->elements, ELEMENTS_MOST);
	if (check->bodies > BODIES_MOST)
		return refuse(check, "bodies", (double)check->bodies, BODIES_MOST);
	if (check->keys > KEYS_MOST)
		return refuse(check, "keyframes", (double)check->keys, KEYS_MOST);
	const double freedoms = check->freedoms + (double)check->joints * fmax(check->heaviest, 1);
	if (!(freedoms <= FREEDOMS_MOST))
		return refuse(check, "degrees of freedom of its joints and composites", freedoms, FREEDOMS_MOST);
	return check->bytes <= BYTES_MOST ? STATUS_OK : refuse(check, "bytes of its textures, height fields and numerics", check->bytes, BYTES_MOST);
}

/* --- the text --- */

static bool has_text(const char *text, size_t length, const char *part)
{
	const size_t of = strlen(part);
	for (size_t i = 0; i + of <= length; i++)
		if (memcmp(text + i, part, of) == 0)
			return true;
	return false;
}

static size_t line_of(const char *text, const char *at)
{
	size_t line = 1;
	for (; text < at; text++)
		line += *text == '\n';
	return line;
}

/* A URDF is often what a macro language makes; this is what it was made from. */
static enum status refuse_xacro(const struct vehicle_check *check, const char *part, size_t length)
{
	return fail_with(STATUS_INPUT, "%s: %s: it has parts of xacro, a macro language (%.*s); expand it first: xacro %s > model.urdf", check->where, check->path,
			 (int)(length < 60 ? length : 60), part, check->path);
}

/* MuJoCo reads nothing of these. */
static bool is_ignored(const struct vehicle_xml *xml)
{
	static const char *const names[] = {"gazebo", "transmission", "ros2_control", "plugin"};
	for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
		if (vehicle_xml_is(xml->name, xml->name_length, names[i]))
			return true;
	return false;
}

static enum status check_text(struct vehicle_check *check, const char *path, const char *text, size_t length)
{
	struct vehicle_xml xml = vehicle_xml_begin(text, length);
	enum vehicle_xml_event event;
	int in_default = 0; /* depth of the outermost <default> that is open; 0: none */
	bool ignored = false; /* in a part of a URDF that is for other programs */
	while ((event = vehicle_xml_next(&xml)) == VEHICLE_XML_OPEN || event == VEHICLE_XML_CLOSE) {
		if (event == VEHICLE_XML_CLOSE) {
			in_default = xml.depth < in_default ? 0 : in_default;
			continue;
		}
		struct element element = {.size = 0};
		struct vehicle_xml_attribute attribute;
		check->urdf = check->urdf || (xml.depth == 1 && vehicle_xml_is(xml.name, xml.name_length, "robot"));
		if (xml.depth == 2)
			ignored = check->urdf && is_ignored(&xml);
		if (ignored)
			continue;
		if (check->urdf && has_text(xml.name, xml.name_length, "xacro:"))
			return refuse_xacro(check, xml.name, xml.name_length);
		if (xml.depth > DEPTH_MOST)
			return refuse(check, "elements in each other", xml.depth, DEPTH_MOST);
		if (in_default == 0 && vehicle_xml_is(xml.name, xml.name_length, "default"))
			in_default = xml.depth;
		while (vehicle_xml_attribute(&xml, &attribute)) {
			if (check->urdf && (has_text(attribute.value, attribute.value_length, "${") || has_text(attribute.value, attribute.value_length, "$(")))
				return refuse_xacro(check, attribute.value, attribute.value_length);
			TRY(check_limits(check, &xml, &attribute));
			TRY(take_names(check, &xml, &attribute));
			check->welded = check->welded || (xml.depth == 2 && vehicle_xml_is(xml.name, xml.name_length, "link") && vehicle_xml_is(attribute.name, attribute.name_length, "name") &&
							  vehicle_xml_is(attribute.value, attribute.value_length, "world"));
			take_number(&element, &attribute);
		}
		TRY(add_element(check, &xml, &element, in_default > 0));
	}
	if (event == VEHICLE_XML_BAD)
		return fail_with(STATUS_INPUT, "%s: %s: line %zu: its XML is not whole; give an MJCF or URDF file that MuJoCo reads", check->where, path, line_of(text, xml.at));
	return STATUS_OK;
}

static enum status check_file(struct vehicle_check *check, const char *path)
{
	char *text;
	size_t length;
	TRY(vehicle_check_read(check, path, &text, &length));
	enum status status = check_text(check, path, text, length);
	mem_free(text);
	return status;
}

static enum status check_include(struct vehicle_check *check, const char *name)
{
	char *path = vehicle_check_path(check, NULL, name);
	enum status status;
	TRY_MEM(path, "a vehicle");
	TRY_OR(done, vehicle_check_name(check, name));
	TRY_OR(done, check_file(check, path));
done:
	mem_free(path);
	return status;
}

/* What an included text includes is behind it in the list. */
static enum status check_includes(struct vehicle_check *check)
{
	size_t read = 0;
	for (size_t i = 0; i < check->name_count; i++) {
		if (!check->names[i].include)
			continue;
		if (++read > INCLUDES_MOST)
			return refuse(check, "includes", (double)read, INCLUDES_MOST);
		TRY(check_include(check, check->names[i].text));
	}
	return STATUS_OK;
}

static enum status check_all(struct vehicle_check *check)
{
	TRY(vehicle_check_reach(check));
	TRY(check_file(check, check->path));
	TRY(check_includes(check));
	for (size_t i = 0; i < check->name_count; i++)
		TRY(vehicle_check_name(check, check->names[i].text));
	return check->bytes <= BYTES_MOST ? STATUS_OK : refuse(check, "bytes of its textures, height fields and numerics", check->bytes, BYTES_MOST);
}

enum status vehicle_check_model(const char *where, const char *path, bool *urdf, bool *welded)
{
	struct vehicle_check check = {.where = where, .path = path};
	enum status status = check_all(&check);
	for (size_t i = 0; i < check.name_count; i++)
		mem_free(check.names[i].text);
	for (size_t i = 0; i < check.folder_count; i++)
		mem_free(check.folders[i]);
	mem_free_all(check.names, check.reach);
	*urdf = check.urdf;
	*welded = check.welded;
	return status;
}
