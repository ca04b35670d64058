/* SPDX-License-Identifier: Apache-2.0
 *
 * GnoSphere's C interface: C99, the only stable binary interface of the library. docs/c.md shows how to use it.
 * gnosphere_vulkan.h has what needs Vulkan's headers: scans on a Vulkan device of the caller.
 *
 * Status: every function that can fail returns a gno_status. gno_last_error() has the sentence that says what is wrong
 * and what to do. No exception leaves the library.
 *
 * Handles: a handle is never dereferenced and its value is never used again, so a null handle, a destroyed one and one
 * of another kind are all errors. Every object that a function creates has a gno_..._destroy(). Handles that go into
 * another object are copied there: they may be destroyed afterwards.
 *
 * Structs: a struct whose first member is struct_size must be made by its gno_..._init() function, which sets that
 * member and the default values. A program that was compiled with an older header has smaller structs: members that it
 * lacks have their default values. A struct that is larger than the library's is an error, and so is an entry of an
 * array whose struct_size is not that of the first entry.
 *
 * Pointers: arrays and texts that go in are copied before the function returns. Arrays of a handle (gno_scan_get_column
 * and others) live until the handle is destroyed or changed. Texts and lists of no handle, and those that a call makes
 * anew (of gno_sensor_to_json, gno_effects_to_json, gno_scene_get_left_out, and the list gno_mesh::morph_targets), are
 * valid until the same thread calls the same function again, for whatever handle, or ends. Texts are UTF-8 and end with
 * a zero.
 *
 * Threads: every function may be called by any thread; calls with the same handle wait for each other.
 *
 * Functions of the caller, such as gno_options::warn, run in the call that calls them, on its thread and one after the
 * other. They must return: an exception ends the call with GNO_CANCELLED, and longjmp() is not allowed. They may
 * call the library, but not change what the call uses that they run in. Two threads must not scan crosswise, each with
 * the simulator whose call the other one is in, because both would wait for ever.
 *
 * Processes: one that was forked makes its own simulators, and calls of its parent's are errors, except destroying
 * them. Its parent must fork while no other thread makes or destroys a simulator, because Vulkan's loader and drivers
 * then hold locks that are never free in the forked process; nor may another thread be in a call with a scene, sensor,
 * scan or other object that the forked process uses. It ends by _exit(), because with Mesa's lavapipe exit() waits for
 * threads that only its parent has. dlclose() leaves the library in the process.
 *
 * Units: metres, seconds and radians, unless a name says otherwise. Frames are right-handed: x forward, y left, z up.
 */
#ifndef GNOSPHERE_H
#define GNOSPHERE_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#if defined(_WIN32) && defined(GNOSPHERE_EXPORTS)
#define GNO_API __declspec(dllexport)
#elif defined(__GNUC__) && !defined(_WIN32)
#define GNO_API __attribute__((visibility("default")))
#else
#define GNO_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The version of this header. gno_version() tells that of the library: 10000 * major + 100 * minor + patch. */
#define GNO_VERSION 300

/* ------------------------------------------------------------------------------------------------ status */

/* How a call ended. */
typedef int32_t gno_status;
enum {
  GNO_OK = 0,
  GNO_INVALID_ARGUMENT = 1, /* the call was wrong; every other status means that it could not be carried out */
  GNO_FILE = 2,             /* a file cannot be read or written */
  GNO_FORMAT = 3,           /* the content of a file is invalid */
  GNO_DEVICE = 4,
  GNO_OUT_OF_MEMORY = 5,
  GNO_CANCELLED = 6, /* a function of the caller ended the call, or threw an exception */
  GNO_INTERNAL = 7   /* a mistake in the library */
};

/* The sentence of the last call of this thread that failed; empty if none has. Valid until the next one fails, or the
 * thread ends. */
GNO_API const char* gno_last_error(void);
/* The version of the library, as GNO_VERSION is. */
GNO_API uint32_t gno_version(void);

/* ----------------------------------------------------------------------------------------------- handles */

typedef struct gno_scene_object* gno_scene;                   /* everything that a sensor can see, as plain data */
typedef struct gno_sensor_object* gno_sensor;                 /* a grid of beams, or lists of beams */
typedef struct gno_effects_object* gno_effects;               /* what a scan simulates beside geometry */
typedef struct gno_material_table_object* gno_material_table; /* optical properties by material name */
typedef struct gno_simulator_object* gno_simulator;           /* a scene and sensors on a device */
typedef struct gno_scan_object* gno_scan;                     /* the result of a scan, or a cloud from a file */
typedef struct gno_batch_object* gno_batch;                   /* the results of many shots */

#define GNO_NONE 0xffffffffu /* no triangle, instance, mesh, image, node, skin or clip */

/* ------------------------------------------------------------------------------------------------- scene */

/* Position (metres) and orientation (quaternion x, y, z, w of any length but 0): maps the sensor frame to the world
 * frame. */
typedef struct gno_pose {
  double position[3];
  double orientation[4];
} gno_pose;

/* An affine map to the world frame, row-major 3x4; the fourth column is the translation in metres. */
typedef struct gno_transform {
  double rows[12];
} gno_transform;

/* What the alpha of a material means, as in glTF, and how a texture goes on beyond its edge. */
typedef int32_t gno_alpha_mode;
enum { GNO_ALPHA_OPAQUE = 0, GNO_ALPHA_MASK = 1, GNO_ALPHA_BLEND = 2 };
typedef int32_t gno_wrap;
enum { GNO_WRAP_REPEAT = 0, GNO_WRAP_MIRROR = 1, GNO_WRAP_CLAMP = 2 };

/* The alpha channel of a texture; row 0 is at v = 0. */
typedef struct gno_alpha_image {
  size_t struct_size;
  uint32_t width, height;
  const uint8_t* alpha; /* width * height values, row by row */
  gno_wrap wrap_u, wrap_v;
} gno_alpha_image;

/* Surface properties in the terms of glTF's metallic-roughness model. Factors lie in 0..1. */
typedef struct gno_material {
  size_t struct_size;
  const char* name; /* may be null */
  float base_color[4];
  float metallic, roughness, transmission;
  gno_alpha_mode alpha_mode;
  float alpha_cutoff;
  uint32_t alpha_image;   /* index of an image of the scene, or GNO_NONE */
  float retro;            /* retro-reflection: gain over a Lambertian surface of reflectance 1; 0 for none */
  int32_t double_sided;   /* not 0: both faces reflect */
  uint16_t class_id;      /* semantic class, numbered by the caller; 0: that of the instance counts */
  const char* class_name; /* class that the file states by its name instead; may be null */
} gno_material;

/* A run of triangles of one mesh that share a material. */
typedef struct gno_mesh_part {
  uint32_t first_triangle, triangle_count, material;
} gno_mesh_part;

/* Where the joints and morph targets of a deformable mesh are. All zeros: the vertices are at gno_mesh::positions. */
typedef struct gno_deformation {
  /* By joint: maps a vertex of the mesh frame to where the joint takes it, in the mesh frame. In the terms of glTF:
   * inverse(node of the mesh) * node of the joint * inverse bind matrix. */
  const gno_transform* joints;
  size_t joint_count;         /* gno_mesh::joint_count */
  const float* morph_weights; /* by morph target: its share */
  size_t morph_weight_count;  /* gno_mesh::morph_target_count */
} gno_deformation;

/* Indexed triangles. Vertex v is at origin + positions[3v..3v+2] in the mesh frame. */
typedef struct gno_mesh {
  size_t struct_size;
  const char* name; /* may be null */
  double origin[3];
  const float* positions; /* 3 per vertex, metres */
  size_t vertex_count;
  const uint32_t* indices; /* 3 per triangle, counter-clockwise seen from the front */
  size_t triangle_count;
  const float* uvs;           /* 2 per vertex, or null */
  const gno_mesh_part* parts; /* in ascending order, covering every triangle; null: all triangles have material 0 */
  size_t part_count;
  /* A deformable mesh has joints, morph targets or both. A vertex first moves by the morph targets, each with its
   * weight; then it is the mean of where its joints take it, by their weights. */
  uint32_t joint_count;
  uint32_t influences;    /* joints that each vertex follows, at most 16 */
  const uint16_t* joints; /* `influences` per vertex, each less than joint_count */
  /* `influences` per vertex, not negative; those of a vertex sum to 1 within 0.001, and are divided by their sum */
  const float* joint_weights;
  const float* const* morph_targets; /* per target 3 per vertex: by how much it moves them, metres */
  size_t morph_target_count;
  gno_deformation deformation; /* at first; see gno_simulator_set_deformation() */
} gno_mesh;

/* One placement of a mesh in the world. */
typedef struct gno_instance {
  size_t struct_size;
  const char* name; /* may be null */
  uint32_t mesh;
  uint16_t class_id; /* of all surfaces whose material states none, numbered by the caller; 0 for none */
  gno_transform transform;
  const char* class_name; /* class that the file states by its name instead; may be null */
  uint32_t world;         /* the world that has it, see gno_shot::world; 0 for all of them */
} gno_instance;

/* How a file of a scene is read: which of its axes points up, and in which unit it is. */
typedef int32_t gno_up_axis;
enum { GNO_UP_FORMAT_DEFAULT = 0, GNO_UP_Y = 1, GNO_UP_Z = 2 };
typedef struct gno_load_options {
  size_t struct_size;
  gno_up_axis up; /* by default that of the format: y for glTF, z for OBJ, PLY and STL */
  double scale;   /* metres per unit of the file */
} gno_load_options;

/* How many things a scene has. */
typedef struct gno_scene_counts {
  size_t struct_size;
  size_t materials, alpha_images, meshes, instances;
  size_t unread_images; /* images of cut-out materials that are missing or not PNG */
  size_t unique_triangles, placed_triangles;
  size_t nodes, skins, clips, animated_instances; /* see "animation" */
} gno_scene_counts;

/* Diffuse reflectance, share and roughness of gloss, retro gain and transmission of a material at a wavelength. */
typedef struct gno_optics {
  float reflectance, gloss, roughness, retro, transmission;
} gno_optics;

/* Makes a scene without anything in it. */
GNO_API gno_status gno_scene_create(gno_scene* scene);
/* Reads .gltf, .glb, .obj, .ply or .stl; options may be null. */
GNO_API gno_status gno_scene_load(const char* file, const gno_load_options* options, gno_scene* scene);
GNO_API gno_status gno_scene_destroy(gno_scene scene);
/* Each of these adds a copy and gives its index; the index may be null. */
GNO_API gno_status gno_scene_add_alpha_image(gno_scene scene, const gno_alpha_image* image, uint32_t* index);
GNO_API gno_status gno_scene_add_material(gno_scene scene, const gno_material* material, uint32_t* index);
GNO_API gno_status gno_scene_add_mesh(gno_scene scene, const gno_mesh* mesh, uint32_t* index);
GNO_API gno_status gno_scene_add_instance(gno_scene scene, const gno_instance* instance, uint32_t* index);
/* Appends a copy of `other`, moved by `transform` (null: not moved): alpha images, materials, meshes, instances, skins
 * and clips get the indices that follow, in their order; nodes do, too, behind one more, which moves them, if both
 * scenes have nodes. `first_instance` (may be null) gets the index of the first of these instances. Each call copies
 * both scenes. */
GNO_API gno_status gno_scene_join(gno_scene scene, gno_scene other, const gno_transform* transform,
                                  uint32_t* first_instance);
GNO_API gno_status gno_scene_get_counts(gno_scene scene, gno_scene_counts* counts);
GNO_API gno_status gno_scene_get_alpha_image(gno_scene scene, size_t index, gno_alpha_image* image);
GNO_API gno_status gno_scene_get_material(gno_scene scene, size_t index, gno_material* material);
GNO_API gno_status gno_scene_get_mesh(gno_scene scene, size_t index, gno_mesh* mesh);
GNO_API gno_status gno_scene_get_instance(gno_scene scene, size_t index, gno_instance* instance);
/* The box around all finite vertices that triangles use, in the world frame; min > max if there are none. */
GNO_API gno_status gno_scene_get_bounds(gno_scene scene, double min[3], double max[3]);
/* An error that names the material, image, mesh, part, instance, node, skin or clip whose indices or sizes are
 * inconsistent. */
GNO_API gno_status gno_scene_validate(gno_scene scene);
/* In names U+FFFD takes the place of what is not UTF-8. */
GNO_API gno_status gno_scene_write_glb(gno_scene scene, const char* file);
/* The optics of every material of a valid scene at a wavelength of 905 or 1550 nm. table may be null. Writes at most
 * `capacity` and gives the number that there are. */
GNO_API gno_status gno_scene_get_optics(gno_scene scene, gno_material_table table, double wavelength,
                                        gno_optics* optics, size_t capacity, size_t* count);

/* The positions of a mesh in a deformation, or if that is null in its own: 3 per vertex, in metres relative to
 * gno_mesh::origin. All devices see these. */
GNO_API gno_status gno_scene_get_deformed_positions(gno_scene scene, size_t mesh, const gno_deformation* deformation,
                                                    float* positions, size_t vertex_count);
/* What the scene leaves out of its file: a line per kind of content, such as vertex colours, with the number of times
 * that it occurs, and a line per material library that cannot be read. */
GNO_API gno_status gno_scene_get_left_out(gno_scene scene, const char** lines);

/* --------------------------------------------------------------------------------------------- animation */

/* A frame that clips move: its map to the frame of its parent is translation * rotation * scale, or `matrix`. */
typedef struct gno_node {
  size_t struct_size;
  const char* name; /* may be null */
  uint32_t parent;  /* index of a node, less than its own; GNO_NONE: none */
  double translation[3];
  double rotation[4]; /* quaternion x, y, z, w of any length but 0 */
  double scale[3];
  const gno_transform* matrix; /* if not null, no clip moves the node */
  const float* morph_weights;  /* of the mesh that it places: as many as its morph targets, or none for all 0 */
  size_t morph_weight_count;
} gno_node;

/* The joints of skinned meshes. */
typedef struct gno_skin {
  size_t struct_size;
  const char* name;                   /* may be null */
  const uint32_t* joints;             /* by joint: index of its node */
  const gno_transform* inverse_binds; /* by joint: maps the mesh frame to the frame of the joint, as it was bound */
  size_t joint_count;
} gno_skin;

/* What a track moves, and how its values go from key to key. */
typedef int32_t gno_track_property;
enum { GNO_TRACK_TRANSLATION = 0, GNO_TRACK_ROTATION = 1, GNO_TRACK_SCALE = 2, GNO_TRACK_MORPH_WEIGHTS = 3 };
typedef int32_t gno_interpolation;
enum { GNO_INTERPOLATION_STEP = 0, GNO_INTERPOLATION_LINEAR = 1, GNO_INTERPOLATION_CUBIC = 2 };

/* How a clip moves one property of one node: values at key times. */
typedef struct gno_track {
  uint32_t node;
  gno_track_property property;
  gno_interpolation interpolation; /* linear: rotations turn by slerp */
  const float* times;              /* seconds from 0 on, ascending; at least one */
  size_t key_count;
  /* Per key 3 values, 4 for a rotation (x, y, z, w), or one per morph target. Cubic: per key the slopes before it, the
   * values, and the slopes after it. */
  const float* values;
  size_t value_count;
} gno_track;

/* A named motion of nodes; "animation" in glTF. At most one track moves a property of a node. */
typedef struct gno_clip {
  size_t struct_size;
  const char* name; /* may be null */
  double duration;  /* seconds */
  const gno_track* tracks;
  size_t track_count;
} gno_clip;

/* An instance that follows a node or a skin. Its transform is root * node * offset. With a skin it is root * offset,
 * and the joints of its mesh are at inverse(offset) * node of the joint * inverse bind. A deformable mesh follows one
 * node and one skin, so instances that follow others have a mesh of their own. */
typedef struct gno_animated_instance {
  size_t struct_size;
  uint32_t instance; /* index of an instance of the scene */
  uint32_t node;     /* its morph weights are those of the mesh */
  uint32_t skin;     /* GNO_NONE: none */
  gno_transform offset;
} gno_animated_instance;

/* Where the instances and the vertices of a scene are at one moment. */
typedef struct gno_scene_state {
  size_t struct_size;
  const gno_transform* transforms; /* by instance; for gno_simulator_set_transform() */
  size_t transform_count;
  const gno_deformation* deformations; /* by mesh, empty unless deformable; for gno_simulator_set_deformation() */
  size_t deformation_count;
} gno_scene_state;

/* What happens outside the time of a clip: it repeats, or its first or last state holds. */
typedef int32_t gno_clip_end;
enum { GNO_CLIP_LOOP = 0, GNO_CLIP_HOLD = 1 };

/* Each of these adds a copy and gives its index; the index may be null. */
GNO_API gno_status gno_scene_add_node(gno_scene scene, const gno_node* node, uint32_t* index);
GNO_API gno_status gno_scene_add_skin(gno_scene scene, const gno_skin* skin, uint32_t* index);
GNO_API gno_status gno_scene_add_clip(gno_scene scene, const gno_clip* clip, uint32_t* index);
GNO_API gno_status gno_scene_add_animated_instance(gno_scene scene, const gno_animated_instance* animated,
                                                   uint32_t* index);
/* Maps the frame above all nodes to the world; the identity if it is not set. */
GNO_API gno_status gno_scene_set_animation_root(gno_scene scene, const gno_transform* root);
GNO_API gno_status gno_scene_get_node(gno_scene scene, size_t index, gno_node* node);
GNO_API gno_status gno_scene_get_skin(gno_scene scene, size_t index, gno_skin* skin);
/* The tracks are valid until the same thread calls this function again; what they point to belongs to the scene. */
GNO_API gno_status gno_scene_get_clip(gno_scene scene, size_t index, gno_clip* clip);
GNO_API gno_status gno_scene_get_animated_instance(gno_scene scene, size_t index, gno_animated_instance* animated);
GNO_API gno_status gno_scene_get_animation_root(gno_scene scene, gno_transform* root);
/* The index of the clip of this name, or, where none has it, of this number, counted from 0. The error for an unknown
 * name tells the nearest names, and the error for a name that several clips have tells their numbers. */
GNO_API gno_status gno_scene_find_clip(gno_scene scene, const char* name, uint32_t* index);
/* The state of the scene `seconds` after the start of a clip; for GNO_NONE as a clip, the state at rest. What the clip
 * does not move is at rest: instances that follow no node keep their transform, and meshes that none of them places
 * their deformation. The arrays are valid until the same thread calls this function again. */
GNO_API gno_status gno_scene_get_state(gno_scene scene, uint32_t clip, double seconds, gno_clip_end end,
                                       gno_scene_state* state);

/* ------------------------------------------------------------------------------------------------ sensor */

/* One laser of a spinning sensor. */
typedef struct gno_channel {
  double elevation_deg;        /* above the horizon */
  double azimuth_offset_deg;   /* added to the column's azimuth */
  double origin[3];            /* x forward along the beam's azimuth, y left, z up */
  double time_offset;          /* seconds between the column's time and the firing of this laser */
  double range_min, range_max; /* greater than 0: these replace the sensor's */
} gno_channel;

/* What happens to a surface that is nearer than the least range of a beam. */
typedef int32_t gno_near_hits;
enum {
  GNO_NEAR_SEE_THROUGH = 0, /* a beam passes through a surface nearer than its least range */
  GNO_NEAR_HIDE = 1         /* such a surface blocks the beam, which has no return */
};

/* What grids and lists have in common. */
typedef struct gno_sensor_settings {
  size_t struct_size;
  const char* name; /* may be null */
  double range_min, range_max;
  double divergence_horizontal, divergence_vertical; /* rad, full angles of a beam's footprint */
  uint32_t max_returns;                              /* echoes that the sensor reports per beam, 1..15 */
  double rotation_period;                            /* seconds of a sweep; 0: all columns fire at once */
  gno_near_hits near_hits;
  const uint32_t* masked_beams; /* indices of beams that never fire */
  size_t masked_beam_count;
  double range_at_10_percent; /* m, from which on a Lambertian target of 10 % is not detected; 0 if not stated */
  double scan_period;         /* seconds from the start of a scan to that of the next; 0: rotation_period */
} gno_sensor_settings;

/* Beam index = channel * columns + column; the beam in column i has the azimuth start + span * i / columns. */
typedef struct gno_grid {
  size_t struct_size;
  uint32_t columns;
  const gno_channel* channels;
  size_t channel_count;
  double azimuth_start_deg, azimuth_span_deg; /* counter-clockwise from the x axis; a negative span turns clockwise */
} gno_grid;

/* Beams in any directions, in the order in which a scan lists them. Arrays other than directions may be null. */
typedef struct gno_beam_list {
  size_t struct_size;
  size_t beam_count;
  const double* directions; /* 3 per beam: unit vectors in the sensor's frame */
  const double* origins;    /* 3 per beam: metres in the sensor's frame; null: its origin */
  const double* times;      /* seconds after the start of the scan; null: 0 */
  const float* range_min;   /* metres; null: the sensor's */
  const float* range_max;   /* metres; null: the sensor's */
  const uint16_t* rings;    /* null: 0 */
  uint32_t width, height;   /* of the organised cloud; 0: one row of all beams */
} gno_beam_list;

/* How many beams a sensor has, and in how many rows and columns. */
typedef struct gno_sensor_size {
  size_t struct_size;
  size_t beams;
  uint32_t width, height; /* of the organised cloud */
  size_t patterns;        /* number of beam lists; 0 for a grid */
} gno_sensor_size;

/* What a sensor file leaves open; null and 0 mean what the file states, or else a default. */
typedef struct gno_sensor_file_options {
  size_t struct_size;
  const char* head; /* a built-in sensor that states what the file does not */
  const char* mode; /* one of several that the file describes */
  double scan_rate; /* scans per second */
  uint32_t columns; /* of a turn */
  uint32_t beams_per_scan;
  const char* fire_times; /* Hesai's file of firing times */
} gno_sensor_file_options;

/* A real head of the catalogue; a null or 0 means that its source does not state it. */
typedef struct gno_catalogue_head {
  size_t struct_size;
  const char *name, *product, *modes, *source, *remarks; /* modes are separated by commas */
  double range_at_10_percent;
} gno_catalogue_head;

/* One of gno_sensor_names() or of the catalogue, the latter with ":MODE" if wanted. */
GNO_API gno_status gno_sensor_builtin(const char* name, gno_sensor* sensor);
/* Reads a sensor file of any family that docs/sensors.md lists; options may be null. */
GNO_API gno_status gno_sensor_load(const char* file, const gno_sensor_file_options* options, gno_sensor* sensor);
/* Reads a sensor file from memory; the ending of `name` says what it is expected to be. */
GNO_API gno_status gno_sensor_read(const void* bytes, size_t size, const char* name,
                                   const gno_sensor_file_options* options, gno_sensor* sensor);
GNO_API gno_status gno_sensor_from_json(const char* json, gno_sensor* sensor);
GNO_API gno_status gno_sensor_create_grid(const gno_sensor_settings* settings, const gno_grid* grid,
                                          gno_sensor* sensor);
/* Scan number n uses pattern n modulo their number. */
GNO_API gno_status gno_sensor_create_list(const gno_sensor_settings* settings, const gno_beam_list* patterns,
                                          size_t pattern_count, gno_sensor* sensor);
GNO_API gno_status gno_sensor_destroy(gno_sensor sensor);
GNO_API gno_status gno_sensor_get_settings(gno_sensor sensor, gno_sensor_settings* settings);
GNO_API gno_status gno_sensor_set_settings(gno_sensor sensor, const gno_sensor_settings* settings);
GNO_API gno_status gno_sensor_get_size(gno_sensor sensor, gno_sensor_size* size);
/* The beams that scan number `frame` fires, for a grid, too. The arrays live until the next call with this sensor. */
GNO_API gno_status gno_sensor_get_beams(gno_sensor sensor, uint64_t frame, gno_beam_list* beams);
GNO_API gno_status gno_sensor_to_json(gno_sensor sensor, const char** json);
/* For a sensor from a file: its family, what was assumed and what was ignored, a line each. Otherwise empty. */
GNO_API gno_status gno_sensor_get_report(gno_sensor sensor, const char** lines);
GNO_API gno_status gno_sensor_names(const char* const** names, size_t* count);
GNO_API gno_status gno_catalogue_count(size_t* count);
GNO_API gno_status gno_catalogue_get(size_t index, gno_catalogue_head* head);

/* ----------------------------------------------------------------------------------------------- effects */

/* Automatic: those that the scene and the sensor call for. */
GNO_API gno_status gno_effects_create(gno_effects* effects);
/* "clean" (geometry alone), "auto", "carla" and others of gno_effect_presets(). */
GNO_API gno_status gno_effects_preset(const char* name, gno_effects* effects);
/* From a JSON file of effects, or of CARLA's attributes, whose lidars must have the same effects. */
GNO_API gno_status gno_effects_load(const char* file, gno_effects* effects);
/* The same of the CARLA lidar with this id. */
GNO_API gno_status gno_effects_load_mode(const char* file, const char* mode, gno_effects* effects);
GNO_API gno_status gno_effects_from_json(const char* json, gno_effects* effects);
GNO_API gno_status gno_effects_destroy(gno_effects effects);
/* One assignment as on the command line: "fog.visibility=200" sets a parameter, "divergence=off" the use. */
GNO_API gno_status gno_effects_assign(gno_effects effects, const char* assignment);
GNO_API gno_status gno_effects_set_seed(gno_effects effects, uint64_t seed);
GNO_API gno_status gno_effects_to_json(gno_effects effects, const char** json);
GNO_API gno_status gno_effect_names(const char* const** names, size_t* count);
GNO_API gno_status gno_effect_presets(const char* const** names, size_t* count);

/* Reads the format of GnoSphere or ASAM OpenMATERIAL 3D; a null file gives an empty table. */
GNO_API gno_status gno_material_table_load(const char* file, gno_material_table* table);
/* Adds the optics of the materials of a name. A negative value means not stated; gno_simulator_create() refuses wrong
 * ones. */
GNO_API gno_status gno_material_table_add(gno_material_table table, const char* name, float reflectance905,
                                          float reflectance1550, float roughness, float retro, float transmission);
GNO_API gno_status gno_material_table_destroy(gno_material_table table);

/* ------------------------------------------------------------------------------------------------ fields */

/* What a scan or a cloud file may hold per return. */
typedef int32_t gno_field;
enum { /* docs/api.md says what each is */
       GNO_FIELD_X = 0,
       GNO_FIELD_Y,
       GNO_FIELD_Z,
       GNO_FIELD_RANGE,
       GNO_FIELD_RING,
       GNO_FIELD_BEAM,
       GNO_FIELD_TRIANGLE,
       GNO_FIELD_INSTANCE,
       GNO_FIELD_TIE,
       GNO_FIELD_TOLERANCE,
       GNO_FIELD_INTENSITY,
       GNO_FIELD_TRUE_RANGE,
       GNO_FIELD_CAUSE,
       GNO_FIELD_LABEL,
       GNO_FIELD_RETURN_NUMBER,
       GNO_FIELD_RETURN_COUNT,
       GNO_FIELD_WIDTH,
       GNO_FIELD_NORMAL,
       GNO_FIELD_INCIDENCE,
       GNO_FIELD_MATERIAL,
       GNO_FIELD_BARYCENTRICS,
       GNO_FIELD_CLASS_ID,
       GNO_FIELD_VELOCITY,
       GNO_FIELD_RADIAL_SPEED,
       GNO_FIELD_TIME,
       GNO_FIELD_AZIMUTH,
       GNO_FIELD_ELEVATION
};

/* The values of GNO_FIELD_CAUSE: what became of a beam. gno_counters::causes counts them in this order. */
typedef uint8_t gno_cause;
enum {
  GNO_CAUSE_RETURNED = 0,    /* the beam has at least one return */
  GNO_CAUSE_NO_SURFACE = 1,  /* there is no surface in range */
  GNO_CAUSE_WEAK = 2,        /* all echoes are below the detection threshold */
  GNO_CAUSE_ATTENUATED = 3,  /* as weak, but only because of fog, rain, snow or dust */
  GNO_CAUSE_DROPPED_OUT = 4, /* the return was lost at random */
  GNO_CAUSE_DEAD = 5,        /* the beam is dead by the effect drop-out, or masked by the sensor */
  GNO_CAUSE_TOO_NEAR = 6,    /* a surface nearer than the least range blocks the beam, see gno_near_hits */
  GNO_CAUSE_NOT_CHOSEN = 7   /* its echoes are detected, but returns.mode names none that there is */
};

/* The values of GNO_FIELD_LABEL: the origin of a return. */
typedef uint8_t gno_label;
enum {
  GNO_LABEL_NONE = 0,   /* there is no return */
  GNO_LABEL_SOLID = 1,  /* a surface */
  GNO_LABEL_SCATTER = 2 /* particles of fog, rain, snow or dust */
};

/* The type of a number in memory, in the byte order of the machine. */
typedef int32_t gno_value_type;
enum { GNO_F32 = 0, GNO_F64 = 1, GNO_U8 = 2, GNO_U16 = 3, GNO_U32 = 4 };

/* Name, type and number of components of a field. */
typedef struct gno_field_description {
  size_t struct_size;
  const char* name;
  gno_value_type type;
  uint32_t components;
} gno_field_description;

/* Describes a field. */
GNO_API gno_status gno_field_describe(gno_field field, gno_field_description* description);
/* Parses a list such as "x,y,z,range". Writes at most `capacity` fields and gives the number that there are. */
GNO_API gno_status gno_fields_parse(const char* names, gno_field* fields, size_t capacity, size_t* count);

/* One value of a packed row, or a column. */
typedef struct gno_layout_value {
  gno_field field;
  uint32_t component;
  size_t offset;       /* bytes from the start of the row */
  gno_value_type type; /* the field's own, or one that holds all of its values */
  /* 0 if the value is part of the row. Otherwise the values of all rows form a column that begins at byte `offset` of
   * the buffer, a multiple of 4, with a value every `stride` bytes: the size of the type, or a larger multiple of 4,
   * where a value of 1 or 2 bytes takes a word of 4, in which 0 follows. Only results that stay on a device may have
   * columns. */
  size_t stride;
} gno_layout_value;
/* How the results of a scan lie in memory. The bytes of a row that no value has become 0 on a device, and
 * gno_scan_pack() leaves them as they are. */
typedef struct gno_layout {
  size_t struct_size;
  const gno_layout_value* values;
  size_t value_count;
  size_t stride;   /* bytes from row to row; 0 if all values are in columns */
  int32_t compact; /* not 0: only entries with a return become rows */
} gno_layout;

/* The header of results that stay on a device. The first four numbers are the arguments of an indirect draw with a
 * vertex per row (VkDrawIndirectCommand). */
typedef struct gno_record_header {
  uint32_t rows;           /* in the buffer */
  uint32_t instance_count; /* always 1 */
  uint32_t first_vertex, first_instance;
  uint32_t wanted;     /* rows that the scan has; more than `rows` if the buffer is too small */
  uint32_t hits;       /* returns of all beams */
  uint32_t incomplete; /* not 0 if a list was too small, so that hits may be missing */
  uint32_t frame;      /* low 32 bits of gno_shot::frame */
} gno_record_header;

/* Rows of the fields without gaps. The values are valid until the same thread calls this function again. */
GNO_API gno_status gno_layout_of(const gno_field* fields, size_t field_count, gno_layout* layout);
/* The bytes that so many rows need on a device. */
GNO_API gno_status gno_layout_bytes_for(const gno_layout* layout, uint64_t rows, uint64_t* bytes);

/* ----------------------------------------------------------------------------------------------- devices */

/* A device of this machine, and whether it can be used. Programs step through arrays of it, so it never grows: what is
 * added gets functions of its own. */
typedef struct gno_device_info {
  size_t struct_size;
  const char* name;
  const char* type; /* "discrete", "integrated", "virtual", "cpu", "other", "cuda" or "reference" */
  const char* driver;
  const char* api_version;
  uint64_t max_buffer_bytes;
  uint32_t subgroup_size;
  int32_t usable;
  const char* reason; /* why it is not usable */
  uint8_t uuid[16];
} gno_device_info;

/* Lists every device of this machine. `problem` (may be null) gets why there is no Vulkan device, or an empty text. */
GNO_API gno_status gno_devices(const gno_device_info** devices, size_t* count, const char** problem);

/* --------------------------------------------------------------------------------------------- simulator */

/* How exact a scan is. docs/accuracy.md has what each accuracy costs and gets wrong. */
typedef int32_t gno_accuracy;
enum { GNO_ACCURACY_PAPER = 0, GNO_ACCURACY_DRAFT = 1, GNO_ACCURACY_STANDARD = 2, GNO_ACCURACY_EXACT = 3 };

/* Which faces of a triangle reflect. */
typedef int32_t gno_faces;
enum { GNO_FACES_MATERIAL = 0, GNO_FACES_FRONT = 1, GNO_FACES_BOTH = 2 };

/* A Vulkan device of the caller, see gnosphere_vulkan.h. */
typedef struct gno_vulkan_adopted_device gno_vulkan_adopted_device;

/* How a simulator computes, and on which device. */
typedef struct gno_options {
  size_t struct_size;
  const char* device; /* "auto", "gpu", "reference", "cuda:N", number or part of a name of gno_devices(); null: auto */
  uint8_t device_uuid[16];                  /* gno_device_info::uuid of a Vulkan device; all zeros: by `device` */
  const gno_vulkan_adopted_device* adopted; /* not null: the caller's device, and the two above are ignored */
  gno_accuracy accuracy;
  gno_faces faces;
  gno_material_table materials; /* may be null */
  const char* cache;            /* folder of compiled kernels; null: the default; "off": none */
  /* Gets a sentence about a problem that is no error; may be null. */
  void (*warn)(const char* message, void* user);
  void* user;
  int32_t validation;      /* not 0: the Vulkan validation layer is on */
  const char* assignments; /* what gno_options_set() has set; it replaces the members above */
} gno_options;

/* Sets an option by its name, as "tuning.binning=lists" or "accuracy=exact"; docs/options.md lists the names, of which
 * the struct has the most used ones alone. An error has the nearest known names, or the values that the option takes;
 * the options are then unchanged. What an earlier call has set for the same name is replaced. The library keeps the
 * texts that have been set until the process ends, each once. */
GNO_API gno_status gno_options_set(gno_options* options, const char* assignment);

/* A sensor, the effects that its scans simulate, and the fields that its scans hold. */
typedef struct gno_request {
  size_t struct_size;
  gno_sensor sensor;
  gno_effects effects; /* null: automatic */
  /* Beyond x, y, z, range, triangle and instance; with the option results_on_device, beyond range. */
  const gno_field* fields;
  size_t field_count;
  int32_t variable_weather; /* not 0: shots may set their weather */
  /* Results that stay on a device lie like this: in the caller's buffers on a device of the caller, and with the option
   * results_on_device in those of a gno_batch_stream, which has columns of ranges and `fields` if this is null. Its
   * fields need not be repeated above. Without any of the two it must be null. */
  const gno_layout* layout;
  /* Instances that the sensor does not see, for example the body of the robot that carries it. If an instance is
   * removed, its index leaves the list, so that another one that gets it is seen. */
  const uint32_t* ignored_instances;
  size_t ignored_instance_count;
} gno_request;

/* Dust or spray that fills an axis-aligned box of the world. */
typedef struct gno_volume {
  double min[3], max[3];
  double extinction; /* 1/m */
} gno_volume;
typedef struct gno_weather {
  size_t struct_size;
  double visibility;           /* m; 0 for no fog */
  double rain_rate, snow_rate; /* mm/h */
  const gno_volume* volumes;
  size_t volume_count;
} gno_weather;

/* A pose of the sensor at a time in seconds after the start of the scan. */
typedef struct gno_stamp {
  double time;
  gno_pose pose;
} gno_stamp;
/* An instance moves from its own transform at the start of the scan to `end` at its end. */
typedef struct gno_instance_motion {
  size_t instance;
  gno_transform end;
} gno_instance_motion;

/* A deformable mesh moves from its deformation at the start of the scan to `end` at its end. Vertices move along
 * straight lines at constant speed, those of every instance of the mesh. */
typedef struct gno_mesh_motion {
  size_t mesh;
  gno_deformation end;
} gno_mesh_motion;

/* One scan of a run. */
typedef struct gno_shot {
  size_t struct_size;
  gno_pose pose;  /* of the sensor without a motion; with one, the frame of points that sensor-motion deskews */
  size_t sensor;  /* index in the simulator */
  uint64_t frame; /* part of the key of the random numbers, and of a list the number of the pattern */
  /* Where the sensor is during the scan, with ascending times; null: at `pose`. Between stamps the position is
   * interpolated linearly and the orientation by slerp; before the first and after the last one the pose is held.
   * Several stamps, all before the first or after the last beam, are an error. Points are those of a sensor at `pose`
   * where the effect sensor-motion is left out: with presets such as "clean", and for sensors whose beams fire all at
   * once. The plan of the sensor tells. */
  const gno_stamp* motion;
  size_t motion_count;
  const gno_instance_motion* instance_motions;
  size_t instance_motion_count;
  const gno_mesh_motion* mesh_motions;
  size_t mesh_motion_count;
  const gno_weather* weather; /* may be null */
  uint32_t world; /* the shot sees the instances of this world and those of world 0, as if there were no others */
  /* Instances that the shot does not see, beside those of gno_request::ignored_instances: of many robots in one world
   * that share a sensor, the body of the one that carries it. Effects are planned as if it saw them. */
  const uint32_t* ignored_instances;
  size_t ignored_instance_count;
} gno_shot;

/* Bytes of device memory by purpose. */
typedef struct gno_memory_use {
  size_t struct_size;
  uint64_t scene, sensor, work;
} gno_memory_use;

/* Uploads the scene and compiles the stages (on a CPU the first scan does that); options may be null. */
GNO_API gno_status gno_simulator_create(gno_scene scene, const gno_request* sensors, size_t sensor_count,
                                        const gno_options* options, gno_simulator* simulator);
GNO_API gno_status gno_simulator_destroy(gno_simulator simulator);
/* Makes one scan. If *scan is null, a scan is created; otherwise its memory is used again, and the scan is empty if the
 * device fails or memory runs out. */
GNO_API gno_status gno_simulator_scan(gno_simulator simulator, const gno_shot* shot, gno_scan* scan);
/* Makes many scans, pipelined. `receive` gets the index of the shot and a scan that it may read until it returns; it
 * must not call this simulator, nor scan into this scan. If it returns another value than 0, the run ends with
 * GNO_CANCELLED. */
GNO_API gno_status gno_simulator_scan_all(gno_simulator simulator, const gno_shot* shots, size_t shot_count,
                                          int32_t (*receive)(size_t shot, gno_scan scan, void* user), void* user);
/* Makes the scans of many shots of one sensor and collects them in arrays, see gno_batch_info. `fields` are those that
 * the batch has beside the ranges; null: all that scans of the sensor have. If *batch is null, a batch is created;
 * otherwise its memory is used again, and the batch is empty if the device fails or memory runs out. The error names
 * the first shot that is not valid, before anything runs. */
GNO_API gno_status gno_simulator_scan_batch(gno_simulator simulator, const gno_shot* shots, size_t shot_count,
                                            const gno_field* fields, size_t field_count, gno_batch* batch);

/* Changes between scans. Indices are stable; the index of a removed object is given to the next one added. */
GNO_API gno_status gno_simulator_add_sensor(gno_simulator simulator, const gno_request* request, size_t* index);
GNO_API gno_status gno_simulator_remove_sensor(gno_simulator simulator, size_t index);
/* `image` (may be null) is the alpha channel of the texture; gno_material::alpha_image is ignored. */
GNO_API gno_status gno_simulator_add_material(gno_simulator simulator, const gno_material* material,
                                              const gno_alpha_image* image, size_t* index);
/* Replaces a material, also of meshes in use. Of such a material double_sided and class_id must stay as they are, and
 * whether it has an image. */
GNO_API gno_status gno_simulator_set_material(gno_simulator simulator, size_t index, const gno_material* material,
                                              const gno_alpha_image* image);
GNO_API gno_status gno_simulator_remove_material(gno_simulator simulator, size_t index);
GNO_API gno_status gno_simulator_add_mesh(gno_simulator simulator, const gno_mesh* mesh, size_t* index);
GNO_API gno_status gno_simulator_remove_mesh(gno_simulator simulator, size_t index);
/* Moves the vertices of a mesh: 3 values per vertex, relative to gno_mesh::origin. The mesh must not be deformable. */
GNO_API gno_status gno_simulator_set_positions(gno_simulator simulator, size_t mesh, const float* positions,
                                               size_t vertex_count);
/* Moves the joints and morph targets of a deformable mesh; null puts its vertices back to gno_mesh::positions. */
GNO_API gno_status gno_simulator_set_deformation(gno_simulator simulator, size_t mesh,
                                                 const gno_deformation* deformation);
/* Adds an instance, without its name and class_name. */
GNO_API gno_status gno_simulator_add_instance(gno_simulator simulator, const gno_instance* instance, size_t* index);
/* Adds many instances, without their names, and gives `count` indices in the same order; `indices` may be null. */
GNO_API gno_status gno_simulator_add_instances(gno_simulator simulator, const gno_instance* instances, size_t count,
                                               uint32_t* indices);
/* Adds the materials, meshes and instances of a scene, moved by `transform` (null: not moved). Each of the arrays (may
 * be null) gets as many indices as gno_scene_get_counts() states of the scene, in the same order. */
GNO_API gno_status gno_simulator_add_scene(gno_simulator simulator, gno_scene scene, const gno_transform* transform,
                                           uint32_t* materials, uint32_t* meshes, uint32_t* instances);
GNO_API gno_status gno_simulator_remove_instance(gno_simulator simulator, size_t index);
/* Removes many instances; the next ones that are added get their indices, in this order. Everything is checked before
 * anything changes: the error names the first entry of `instances` that does not exist, or that an entry before it
 * names, too. */
GNO_API gno_status gno_simulator_remove_instances(gno_simulator simulator, const uint32_t* instances, size_t count);
GNO_API gno_status gno_simulator_set_transform(gno_simulator simulator, size_t instance,
                                               const gno_transform* transform);
/* Moves many instances in one call. `values` holds `width` numbers per instance: 12, the rows of its gno_transform, or
 * 7, the position x, y, z (metres) of the mesh frame in the world frame and its orientation as a quaternion x, y, z, w
 * of any length but zero. Of equal indices the last one counts. Everything is checked before anything changes: the
 * error names the first entry of `instances` that does not exist, or whose values are not finite. */
GNO_API gno_status gno_simulator_set_transforms(gno_simulator simulator, const uint32_t* instances, size_t count,
                                                const double* values, size_t width);
GNO_API gno_status gno_simulator_set_transforms_float(gno_simulator simulator, const uint32_t* instances, size_t count,
                                                      const float* values, size_t width);

/* What a scan of a sensor computes, and why, as JSON; valid until this function is called again for this simulator. */
GNO_API gno_status gno_simulator_get_plan(gno_simulator simulator, size_t sensor, const char** json);
GNO_API gno_status gno_simulator_get_device(gno_simulator simulator, gno_device_info* device);
GNO_API gno_status gno_simulator_get_memory(gno_simulator simulator, gno_memory_use* use);
GNO_API gno_status gno_simulator_get_cluster_count(gno_simulator simulator, size_t* count);

/* -------------------------------------------------------------------------------------------------- scan */

/* The sensor of a scan, and the size of the scan. */
typedef struct gno_scan_info {
  size_t struct_size;
  const char* sensor;
  uint32_t columns, channels; /* of the organised cloud */
  uint32_t returns;           /* entries per beam: entry beam * returns + k is the beam's k-th return */
  size_t entries;
  gno_pose pose;
} gno_scan_info;

/* The values of one field. Component c of entry i is values[i * stride + c] of the type; the points of a scan are the
 * column GNO_FIELD_X, whose stride is 3. An entry without a value, such as the range of a beam without a return, has
 * NaN in floats other than velocities, GNO_NONE in indices, and 0 in velocities and other integers. */
typedef struct gno_column {
  size_t struct_size;
  const void* values;
  size_t entries;
  size_t stride; /* values, not bytes, from one entry to the next */
  gno_value_type type;
  uint32_t components;
} gno_column;

/* What happened to the scene's triangles and to the sensor's beams; include/gnosphere/scan.hpp describes each. */
typedef struct gno_counters {
  size_t struct_size;
  uint64_t beams, hits, misses, triangles, non_finite, degenerate, culled_by_cluster, reused, culled_by_range,
      culled_by_face, culled_between_beams, culled_hidden, projected, candidates, integer_sides, integer_ranges,
      lost_echoes, retries;
  uint64_t causes[8]; /* beams by gno_cause */
} gno_counters;

/* The time of one stage of a scan. */
typedef struct gno_stage_time {
  const char* name;
  double ms;
} gno_stage_time;
/* On a CPU device gpu_ms is 0 and there are no stages unless the option "tuning.stage_times" is true. */
typedef struct gno_timings {
  size_t struct_size;
  double wall_ms, gpu_ms;
  const gno_stage_time* stages;
  size_t stage_count;
} gno_timings;

/* Destroys a scan, and with it the arrays of its columns. */
GNO_API gno_status gno_scan_destroy(gno_scan scan);
GNO_API gno_status gno_scan_get_info(gno_scan scan, gno_scan_info* info);
/* An error if the scan does not have the field. */
GNO_API gno_status gno_scan_get_column(gno_scan scan, gno_field field, gno_column* column);
/* Gives a new scan with points, normals and velocities in the world frame, to which the scan's pose maps them.
 * If the sensor moves during the scan, the scan must be deskewed. A scan that has been read is refused if its file does
 * not state the sensor's pose, of which only PCD does. */
GNO_API gno_status gno_scan_in_world(gno_scan scan, gno_scan* in_world);
GNO_API gno_status gno_scan_get_counters(gno_scan scan, gno_counters* counters);
/* The stages are valid until this function is called again for this scan, or the scan changes. */
GNO_API gno_status gno_scan_get_timings(gno_scan scan, gno_timings* timings);

/* The results of many shots of one sensor. A shot of a batch is a view, and entries lie view after view: entry
 * (view * beams + beam) * returns + k is the beam's k-th return in that view. */
typedef struct gno_batch_info {
  size_t struct_size;
  const char* sensor;
  uint32_t columns, channels; /* of the organised cloud of a view */
  uint32_t returns;           /* entries per beam */
  size_t views, beams;        /* beams of each view */
  size_t entries;             /* of all views */
} gno_batch_info;

/* Destroys a batch, and with it the arrays of its columns. */
GNO_API gno_status gno_batch_destroy(gno_batch batch);
GNO_API gno_status gno_batch_get_info(gno_batch batch, gno_batch_info* info);
/* The values of all views. An error if the batch does not have the field. */
GNO_API gno_status gno_batch_get_column(gno_batch batch, gno_field field, gno_column* column);
/* Sums over the views. */
GNO_API gno_status gno_batch_get_counters(gno_batch batch, gno_counters* counters);
/* The times of all views together, as gno_scan_get_timings() gives them. */
GNO_API gno_status gno_batch_get_timings(gno_batch batch, gno_timings* timings);

/* ------------------------------------------------------------------------------------------------ output */

/* What a cloud file holds. */
typedef struct gno_cloud_options {
  size_t struct_size;
  /* Null: x y z range ring beam triangle instance, and return_number return_count if beams have several returns. */
  const gno_field* fields;
  size_t field_count;
  /* Not 0: only returns are written. If beams have several returns, the file always is compact: it has a row per
   * return, and with GNO_FIELD_TIE one for a beam without a return that is a tie. */
  int32_t compact;
  int32_t ascii; /* not 0: PCD and PLY are written as text */
} gno_cloud_options;

/* Differences between two clouds of the same beams; include/gnosphere/output.hpp describes each. */
typedef struct gno_comparison {
  size_t struct_size;
  uint64_t beams, hits, missed, false_hits, wrong_owner, wrong_range, ties, tie_differences, tie_missed, tie_false_hits,
      tie_wrong_owner;
  double tie_error_max, range_error_max, range_error_9999, range_error_rms, hit_error_max;
  uint64_t wrong_point;
  double point_error_max;
} gno_comparison;

/* Writes the rows of a scan to `rows` and gives their number; entries * stride bytes always suffice. */
GNO_API gno_status gno_scan_pack(gno_scan scan, const gno_layout* layout, void* rows, size_t bytes, size_t* row_count);
/* Writes the format that the file's ending names, such as .pcd; an unknown one is refused with all that are known.
 * A field that stands twice is refused, too, and one that files of KITTI (.bin) do not have. `options` may be null. */
GNO_API gno_status gno_scan_write(gno_scan scan, const char* file, const gno_cloud_options* options);
/* Writes a range image and a view from above as PNG; the name of the file ends in .png. */
GNO_API gno_status gno_scan_write_picture(gno_scan scan, const char* file);
/* Reads a cloud that gno_scan_write() wrote, if its format tells which beams the points are of, as .pcd does. */
GNO_API gno_status gno_scan_read(const char* file, gno_scan* scan);
/* `tolerance` (metres) applies to beams for which the reference states none. */
GNO_API gno_status gno_scan_compare(gno_scan reference, gno_scan other, double tolerance, gno_comparison* comparison);

/* -------------------------------------------------------------------------------------- default values */

/* Defines TYPE_init(), whose members are 0 but for the statements `defaults`. */
#define GNO_INIT(type, defaults)         \
  static inline type type##_init(void) { \
    type value;                          \
    memset(&value, 0, sizeof value);     \
    value.struct_size = sizeof value;    \
    defaults return value;               \
  }
GNO_INIT(gno_alpha_image, )
GNO_INIT(gno_material, value.base_color[0] = value.base_color[1] = value.base_color[2] = value.base_color[3] = 1;
         value.roughness = 1; value.alpha_cutoff = 0.5f; value.alpha_image = GNO_NONE; value.double_sided = 1;)
GNO_INIT(gno_mesh, )
GNO_INIT(gno_instance, value.transform.rows[0] = value.transform.rows[5] = value.transform.rows[10] = 1;)
GNO_INIT(gno_node, value.parent = GNO_NONE; value.rotation[3] = 1;
         value.scale[0] = value.scale[1] = value.scale[2] = 1;)
GNO_INIT(gno_skin, )
GNO_INIT(gno_clip, )
GNO_INIT(gno_animated_instance, value.skin = GNO_NONE;
         value.offset.rows[0] = value.offset.rows[5] = value.offset.rows[10] = 1;)
GNO_INIT(gno_scene_state, )
GNO_INIT(gno_load_options, value.scale = 1;)
GNO_INIT(gno_scene_counts, )
GNO_INIT(gno_sensor_settings, value.max_returns = 1;)
GNO_INIT(gno_grid, value.azimuth_start_deg = -180; value.azimuth_span_deg = 360;)
GNO_INIT(gno_beam_list, )
GNO_INIT(gno_sensor_size, )
GNO_INIT(gno_sensor_file_options, )
GNO_INIT(gno_catalogue_head, )
GNO_INIT(gno_field_description, )
GNO_INIT(gno_device_info, )
GNO_INIT(gno_options, value.accuracy = GNO_ACCURACY_STANDARD;)
GNO_INIT(gno_request, )
GNO_INIT(gno_weather, )
GNO_INIT(gno_shot, value.pose.orientation[3] = 1;)
GNO_INIT(gno_memory_use, )
GNO_INIT(gno_scan_info, )
GNO_INIT(gno_batch_info, )
GNO_INIT(gno_column, )
GNO_INIT(gno_counters, )
GNO_INIT(gno_timings, )
GNO_INIT(gno_layout, )
GNO_INIT(gno_cloud_options, )
GNO_INIT(gno_comparison, )

#ifdef __cplusplus
}
#endif

#endif
