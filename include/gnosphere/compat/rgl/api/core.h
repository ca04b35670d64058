// SPDX-License-Identifier: Apache-2.0
// The interface of RobotecGPULidar (RGL), levels 0.18 to 0.21, as GnoSphere's libgnosphere_rgl has it. GnoSphere is not
// affiliated with Robotec.ai; the names say what this is compatible with. docs/rgl.md describes what is the same.
//
// Every function returns a status; rgl_get_last_error_string() has the sentence of the calling thread's last call.
// Input arrays are copied before a function returns. A function with `rgl_node_t* node` creates a node if *node is
// null, and gives the node that is there new parameters otherwise. Metres, radians and seconds unless a name says
// otherwise.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifndef _WIN32
#define RGL_VISIBLE __attribute__((visibility("default")))
#elif defined(GNOSPHERE_EXPORTS)
#define RGL_VISIBLE __declspec(dllexport)
#else
#define RGL_VISIBLE
#endif
#ifdef __cplusplus
#define RGL_API extern "C" RGL_VISIBLE
#else
#define RGL_API RGL_VISIBLE
#endif

// The types of the enumerations. C has none before C23; there they are as large as int.
#ifdef __cplusplus
#define RGL_INT32 : int32_t
#define RGL_UINT8 : uint8_t
#else
#define RGL_INT32
#define RGL_UINT8
#endif

// The version that a program is built for. A program may define another one before it includes this file.
#ifndef RGL_VERSION_MAJOR
#define RGL_VERSION_MAJOR 0
#define RGL_VERSION_MINOR 20
#define RGL_VERSION_PATCH 0
#endif

#define RGL_ENTITY_INVALID_ID 0          // the entity id of a ray that hits nothing
#define RGL_DEFAULT_ENTITY_ID 268435455  // the id of an entity that has been given none
#define RGL_SENSOR_ID_DEFAULT 0
#define RGL_SENSOR_ID_NONE (-2147483647 - 1)

typedef struct {
  float value[2];
} rgl_vec2f;
typedef struct {
  float value[3];
} rgl_vec3f;
typedef struct {
  int32_t value[3];
} rgl_vec3i;
/// Row-major; the fourth column is the translation.
typedef struct {
  float value[3][4];
} rgl_mat3x4f;

/// Thresholds of a radar within a range of distances.
typedef struct {
  float begin_distance, end_distance;
  float distance_separation_threshold, radial_speed_separation_threshold, azimuth_separation_threshold;
} rgl_radar_scope_t;

/// The bones that move a vertex. The weights add up to 1; every index is that of a bone.
typedef struct {
  float weights[4];
  int32_t bone_indexes[4];
} rgl_bone_weights_t;

// Handles of the objects that the library makes.
typedef struct Mesh* rgl_mesh_t;
typedef struct Entity* rgl_entity_t;
typedef struct Texture* rgl_texture_t;
typedef struct Node* rgl_node_t;
typedef struct Scene* rgl_scene_t;  ///< there is one scene, and its handle is null

typedef enum RGL_INT32 {
  RGL_RADAR_CLASS_CAR = 0,
  RGL_RADAR_CLASS_TRUCK = 1,
  RGL_RADAR_CLASS_MOTORCYCLE = 2,
  RGL_RADAR_CLASS_BICYCLE = 3,
  RGL_RADAR_CLASS_PEDESTRIAN = 4,
  RGL_RADAR_CLASS_ANIMAL = 5,
  RGL_RADAR_CLASS_HAZARD = 6,
  RGL_RADAR_CLASS_UNKNOWN = 7,
  RGL_RADAR_CLASS_COUNT = 8
} rgl_radar_object_class_t;

typedef enum RGL_INT32 {
  RGL_EXTENSION_PCL = 0,
  RGL_EXTENSION_ROS2 = 1,
  RGL_EXTENSION_UDP = 2,
  RGL_EXTENSION_WEATHER = 3,
  RGL_EXTENSION_COUNT = 4
} rgl_extension_t;

typedef enum RGL_INT32 {
  RGL_SUCCESS = 0,
  RGL_INVALID_ARGUMENT = 1,
  RGL_INVALID_STATE = 2,
  RGL_LOGGING_ERROR = 3,
  RGL_INVALID_API_OBJECT = 4,  ///< a handle that is not known, or no longer
  RGL_INVALID_FILE_PATH = 5,
  RGL_TAPE_ERROR = 6,
  RGL_UDP_ERROR = 7,
  RGL_ROS2_ERROR = 8,
  RGL_INVALID_PIPELINE = 9,  ///< nodes that do not fit together
  RGL_INITIALIZATION_ERROR = 10,
  RGL_NOT_IMPLEMENTED = 404,
  RGL_INTERNAL_EXCEPTION = 500
} rgl_status_t;

typedef enum RGL_INT32 {
  RGL_LOG_LEVEL_ALL = 0,
  RGL_LOG_LEVEL_TRACE = 0,
  RGL_LOG_LEVEL_DEBUG = 1,
  RGL_LOG_LEVEL_INFO = 2,
  RGL_LOG_LEVEL_WARN = 3,
  RGL_LOG_LEVEL_ERROR = 4,
  RGL_LOG_LEVEL_CRITICAL = 5,
  RGL_LOG_LEVEL_OFF = 6,
  RGL_LOG_LEVEL_COUNT = 7
} rgl_log_level_t;

/// Fields that a point may have.
typedef enum RGL_INT32 {
  RGL_FIELD_XYZ_VEC3_F32 = 1,
  RGL_FIELD_INTENSITY_F32 = 2,
  RGL_FIELD_INTENSITY_U8 = 3,
  RGL_FIELD_IS_HIT_I32 = 4,
  RGL_FIELD_IS_GROUND_I32 = 5,  ///< 1 for a point that is not ground
  RGL_FIELD_RAY_IDX_U32 = 6,
  RGL_FIELD_ENTITY_ID_I32 = 7,
  RGL_FIELD_DISTANCE_F32 = 8,
  RGL_FIELD_AZIMUTH_F32 = 9,
  RGL_FIELD_ELEVATION_F32 = 10,
  RGL_FIELD_RING_ID_U16 = 11,
  RGL_FIELD_RETURN_TYPE_U8 = 12,
  RGL_FIELD_TIME_STAMP_F64 = 13,  ///< seconds after the sensor was triggered
  RGL_FIELD_TIME_STAMP_U32 = 14,  ///< nanoseconds after the sensor was triggered
  RGL_FIELD_ABSOLUTE_VELOCITY_VEC3_F32 = 15,
  RGL_FIELD_RELATIVE_VELOCITY_VEC3_F32 = 16,
  RGL_FIELD_RADIAL_SPEED_F32 = 17,
  RGL_FIELD_POWER_F32 = 18,
  RGL_FIELD_RCS_F32 = 19,
  RGL_FIELD_NOISE_F32 = 20,
  RGL_FIELD_SNR_F32 = 21,
  RGL_FIELD_NORMAL_VEC3_F32 = 22,
  RGL_FIELD_INCIDENT_ANGLE_F32 = 23,
  RGL_FIELD_RAY_POSE_MAT3x4_F32 = 24,
  RGL_FIELD_LASER_RETRO_F32 = 25,
  RGL_FIELD_REFLECTIVITY_F32 = 26,
  RGL_FIELD_PADDING_8 = 1024,
  RGL_FIELD_PADDING_16 = 1025,
  RGL_FIELD_PADDING_32 = 1026,
  RGL_FIELD_DYNAMIC_FORMAT = 13842
} rgl_field_t;

// A return mode is the number of returns in its highest byte, and their types from the lowest byte on.
static const int32_t RGL_RETURN_MODE_BIT_SHIFT = 24;
static const int32_t RGL_RETURN_MODE_SINGLE = 1 << 24;
static const int32_t RGL_RETURN_MODE_DUAL = 2 << 24;
static const int32_t RGL_RETURN_TYPE_BIT_SHIFT = 8;

enum rgl_return_type_t RGL_UINT8 {
  RGL_RETURN_TYPE_UNKNOWN = 0,
  RGL_RETURN_TYPE_STRONGEST = 1,
  RGL_RETURN_TYPE_LAST = 2,
  RGL_RETURN_TYPE_SECOND = 3,
  RGL_RETURN_TYPE_FIRST = 4,
  RGL_RETURN_TYPE_SECOND_STRONGEST = 5
};
#ifndef __cplusplus
typedef uint8_t rgl_return_type_t;  // as large as a value of RGL_FIELD_RETURN_TYPE_U8
#endif

typedef enum RGL_INT32 {
  RGL_RETURN_UNKNOWN = 0,
  RGL_RETURN_FIRST = 0x01000004,
  RGL_RETURN_SECOND = 0x01000003,
  RGL_RETURN_LAST = 0x01000002,
  RGL_RETURN_STRONGEST = 0x01000001,
  RGL_RETURN_LAST_STRONGEST = 0x02000102,
  RGL_RETURN_FIRST_LAST = 0x02000204,
  RGL_RETURN_FIRST_STRONGEST = 0x02000104,
  RGL_RETURN_STRONGEST_SECOND_STRONGEST = 0x02000501,
  RGL_RETURN_FIRST_SECOND = 0x02000304
} rgl_return_mode_t;

typedef enum RGL_INT32 { RGL_AXIS_X = 1, RGL_AXIS_Y = 2, RGL_AXIS_Z = 3 } rgl_axis_t;

// Functions of the library as a whole.
RGL_API rgl_status_t rgl_get_version_info(int32_t* out_major, int32_t* out_minor, int32_t* out_patch);
RGL_API rgl_status_t rgl_get_extension_info(rgl_extension_t extension, int32_t* out_available);
RGL_API rgl_status_t rgl_configure_logging(rgl_log_level_t log_level, const char* log_file_path, bool use_stdout);
RGL_API void rgl_get_last_error_string(const char** out_error_string);
/// Destroys every object of the library.
RGL_API rgl_status_t rgl_cleanup(void);

// Functions of meshes, in which `index_count` is the number of triangles.
RGL_API rgl_status_t rgl_mesh_create(rgl_mesh_t* out_mesh, const rgl_vec3f* vertices, int32_t vertex_count,
                                     const rgl_vec3i* indices, int32_t index_count);
RGL_API rgl_status_t rgl_mesh_set_texture_coords(rgl_mesh_t mesh, const rgl_vec2f* uvs, int32_t uv_count);
RGL_API rgl_status_t rgl_mesh_set_bone_weights(rgl_mesh_t mesh, const rgl_bone_weights_t* bone_weights,
                                               int32_t bone_weights_count);
/// The inverse of each bone's transform at rest.
RGL_API rgl_status_t rgl_mesh_set_restposes(rgl_mesh_t mesh, const rgl_mat3x4f* restposes, int32_t bones_count);
RGL_API rgl_status_t rgl_mesh_destroy(rgl_mesh_t mesh);
RGL_API rgl_status_t rgl_mesh_is_alive(rgl_mesh_t mesh, bool* out_alive);

// Functions of entities, which are placed meshes.
RGL_API rgl_status_t rgl_entity_create(rgl_entity_t* out_entity, rgl_scene_t scene, rgl_mesh_t mesh);
RGL_API rgl_status_t rgl_entity_destroy(rgl_entity_t entity);
RGL_API rgl_status_t rgl_entity_set_transform(rgl_entity_t entity, const rgl_mat3x4f* transform);
/// Moves the vertices by their bones to the world; the entity's own transform becomes the identity.
RGL_API rgl_status_t rgl_entity_set_pose_world(rgl_entity_t entity, const rgl_mat3x4f* pose, int32_t bones_count);
RGL_API rgl_status_t rgl_entity_set_id(rgl_entity_t entity, int32_t id);
RGL_API rgl_status_t rgl_entity_set_intensity_texture(rgl_entity_t entity, rgl_texture_t texture);
RGL_API rgl_status_t rgl_entity_set_laser_retro(rgl_entity_t entity, float retro);
/// Gives the entity vertices of its own; the mesh stays as it is.
RGL_API rgl_status_t rgl_entity_apply_external_animation(rgl_entity_t entity, const rgl_vec3f* vertices,
                                                         int32_t vertex_count);
RGL_API rgl_status_t rgl_entity_is_alive(rgl_entity_t entity, bool* out_alive);
/// Rays of the raytrace nodes with this sensor id pass through the entity.
RGL_API rgl_status_t rgl_entity_set_ignored_by_sensor(rgl_entity_t entity, int32_t sensor_id);

// Textures: one byte per texel, row 0 first.
RGL_API rgl_status_t rgl_texture_create(rgl_texture_t* out_texture, const void* texels, int32_t width, int32_t height);
RGL_API rgl_status_t rgl_texture_destroy(rgl_texture_t texture);
RGL_API rgl_status_t rgl_texture_is_alive(rgl_texture_t texture, bool* out_alive);

RGL_API rgl_status_t rgl_scene_set_time(rgl_scene_t scene, uint64_t nanoseconds);

// Functions that make nodes of rays.
RGL_API rgl_status_t rgl_node_rays_from_mat3x4f(rgl_node_t* node, const rgl_mat3x4f* rays, int32_t ray_count);
RGL_API rgl_status_t rgl_node_rays_set_ring_ids(rgl_node_t* node, const int32_t* ring_ids, int32_t ring_ids_count);
RGL_API rgl_status_t rgl_node_rays_set_range(rgl_node_t* node, const rgl_vec2f* ranges, int32_t ranges_count);
/// The time offsets are in milliseconds.
RGL_API rgl_status_t rgl_node_rays_set_time_offsets(rgl_node_t* node, const float* offsets, int32_t offsets_count);
RGL_API rgl_status_t rgl_node_rays_transform(rgl_node_t* node, const rgl_mat3x4f* transform);
RGL_API rgl_status_t rgl_node_gaussian_noise_angular_ray(rgl_node_t* node, float mean, float st_dev,
                                                         rgl_axis_t rotation_axis);

// The node that asks what the rays hit.
RGL_API rgl_status_t rgl_node_raytrace(rgl_node_t* node, rgl_scene_t scene);
RGL_API rgl_status_t rgl_node_raytrace_configure_velocity(rgl_node_t node, const rgl_vec3f* linear_velocity,
                                                          const rgl_vec3f* angular_velocity);
RGL_API rgl_status_t rgl_node_raytrace_configure_distortion(rgl_node_t node, bool enable);
RGL_API rgl_status_t rgl_node_raytrace_configure_non_hits(rgl_node_t node, float nearDistance, float farDistance);
RGL_API rgl_status_t rgl_node_raytrace_configure_mask(rgl_node_t node, const int8_t* rays_mask, int32_t rays_count);
RGL_API rgl_status_t rgl_node_raytrace_configure_beam_divergence(rgl_node_t node, float horizontal_beam_divergence,
                                                                 float vertical_beam_divergence);
RGL_API rgl_status_t rgl_node_raytrace_configure_default_intensity(rgl_node_t node, float default_intensity);
RGL_API rgl_status_t rgl_node_raytrace_configure_return_mode(rgl_node_t node, rgl_return_mode_t return_mode);
RGL_API rgl_status_t rgl_node_raytrace_configure_reflectivity_alpha(rgl_node_t node, float reflectivity_alpha);
RGL_API rgl_status_t rgl_node_raytrace_configure_id(rgl_node_t node, int32_t sensor_id);

// Functions that make nodes of points.
RGL_API rgl_status_t rgl_node_points_transform(rgl_node_t* node, const rgl_mat3x4f* transform);
RGL_API rgl_status_t rgl_node_points_format(rgl_node_t* node, const rgl_field_t* fields, int32_t field_count);
RGL_API rgl_status_t rgl_node_points_yield(rgl_node_t* node, const rgl_field_t* fields, int32_t field_count);
/// Keeps the points whose field is not 0: IS_HIT or IS_GROUND.
RGL_API rgl_status_t rgl_node_points_compact_by_field(rgl_node_t* node, rgl_field_t field);
RGL_API rgl_status_t rgl_node_points_spatial_merge(rgl_node_t* node, const rgl_field_t* fields, int32_t field_count);
RGL_API rgl_status_t rgl_node_points_temporal_merge(rgl_node_t* node, const rgl_field_t* fields, int32_t field_count);
RGL_API rgl_status_t rgl_node_points_from_array(rgl_node_t* node, const void* points, int32_t points_count,
                                                const rgl_field_t* fields, int32_t field_count);
RGL_API rgl_status_t rgl_node_points_filter_ground(rgl_node_t* node, const rgl_vec3f* sensor_up_vector,
                                                   float ground_angle_threshold);
RGL_API rgl_status_t rgl_node_gaussian_noise_angular_hitpoint(rgl_node_t* node, float mean, float st_dev,
                                                              rgl_axis_t rotation_axis);
RGL_API rgl_status_t rgl_node_gaussian_noise_distance(rgl_node_t* node, float mean, float st_dev_base,
                                                      float st_dev_rise_per_meter);
/// Frequency in Hz, power in dBm, gain in dBi, noise in dB.
RGL_API rgl_status_t rgl_node_points_radar_postprocess(rgl_node_t* node, const rgl_radar_scope_t* radar_scopes,
                                                       int32_t radar_scopes_count, float ray_azimuth_step,
                                                       float ray_elevation_step, float frequency,
                                                       float power_transmitted, float cumulative_device_gain,
                                                       float received_noise_mean, float received_noise_st_dev);
/// The time max_prediction_time_frame is in milliseconds.
RGL_API rgl_status_t rgl_node_points_radar_track_objects(rgl_node_t* node, float object_distance_threshold,
                                                         float object_azimuth_threshold,
                                                         float object_elevation_threshold,
                                                         float object_radial_speed_threshold,
                                                         float max_matching_distance, float max_prediction_time_frame,
                                                         float movement_sensitivity);
RGL_API rgl_status_t rgl_node_points_radar_set_classes(rgl_node_t node, const int32_t* entity_ids,
                                                       const rgl_radar_object_class_t* object_classes, int32_t count);
RGL_API rgl_status_t rgl_node_is_alive(rgl_node_t node, bool* out_alive);

// Functions of graphs: a graph is all nodes that are connected with a node.
RGL_API rgl_status_t rgl_graph_run(rgl_node_t node);
RGL_API rgl_status_t rgl_graph_destroy(rgl_node_t node);
RGL_API rgl_status_t rgl_graph_get_result_size(rgl_node_t node, rgl_field_t field, int32_t* out_count,
                                               int32_t* out_size_of);
RGL_API rgl_status_t rgl_graph_get_result_data(rgl_node_t node, rgl_field_t field, void* data);
RGL_API rgl_status_t rgl_graph_node_add_child(rgl_node_t parent, rgl_node_t child);
RGL_API rgl_status_t rgl_graph_node_remove_child(rgl_node_t parent, rgl_node_t child);
RGL_API rgl_status_t rgl_graph_node_set_priority(rgl_node_t node, int32_t priority);
RGL_API rgl_status_t rgl_graph_node_get_priority(rgl_node_t node, int32_t* out_priority);
