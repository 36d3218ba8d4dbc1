/// A scene of Mitsuba 0.6 and the same scene in the terms of Mitsuba 3 make the same bits.

#include "support/scene_rendering.h"
#include "unit/io/support.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

constexpr const char* kOldScene = R"(<?xml version="1.0" encoding="utf-8"?>
<scene version="0.6.0">
    <integrator type="path">
        <integer name="maxDepth" value="6"/>
        <integer name="rrDepth" value="4"/>
        <boolean name="strictNormals" value="false"/>
    </integrator>
    <sensor type="thinlens">
        <string name="fovAxis" value="smaller"/>
        <float name="fov" value="42"/>
        <float name="nearClip" value="0.1"/>
        <float name="apertureRadius" value="0.02"/>
        <float name="focusDistance" value="5"/>
        <transform name="toWorld">
            <lookAt origin="0, 1.5, 5" target="0, 0.6, 0" up="0, 1, 0"/>
        </transform>
        <sampler type="ldsampler">
            <integer name="sampleCount" value="16"/>
        </sampler>
        <film type="ldrfilm">
            <integer name="width" value="32"/>
            <integer name="height" value="24"/>
            <integer name="cropOffsetX" value="2"/>
            <integer name="cropOffsetY" value="1"/>
            <integer name="cropWidth" value="28"/>
            <integer name="cropHeight" value="22"/>
            <float name="gamma" value="2.2"/>
            <rfilter type="gaussian"/>
        </film>
    </sensor>
    <bsdf type="diffuse" id="floor">
        <texture name="diffuseReflectance" type="checkerboard">
            <rgb name="color0" value="0.6, 0.5, 0.4"/>
            <rgb name="color1" value="0.2, 0.2, 0.3"/>
            <float name="uscale" value="4"/>
            <float name="vscale" value="6"/>
            <float name="uoffset" value="0.125"/>
        </texture>
    </bsdf>
    <shape type="rectangle">
        <transform name="toWorld">
            <scale value="4"/>
            <rotate x="1" angle="-90"/>
        </transform>
        <ref id="floor"/>
    </shape>
    <shape type="sphere">
        <point name="center" x="-0.9" y="0.5" z="0"/>
        <float name="radius" value="0.5"/>
        <bsdf type="dielectric">
            <float name="intIOR" value="1.5"/>
            <string name="extIOR" value="air"/>
            <rgb name="specularTransmittance" value="0.9, 1, 0.8"/>
        </bsdf>
    </shape>
    <shape type="cube">
        <transform name="toWorld">
            <scale value="0.35"/>
            <rotate y="1" angle="30"/>
            <translate x="0.9" y="0.35" z="0.3"/>
        </transform>
        <bsdf type="twosided">
            <bsdf type="roughplastic">
                <rgb name="diffuseReflectance" value="0.5, 0.1, 0.1"/>
                <float name="alpha" value="0.15"/>
                <float name="intIOR" value="1.6"/>
            </bsdf>
        </bsdf>
    </shape>
    <shape type="cylinder">
        <point name="p0" x="0.2" y="0" z="-0.8"/>
        <point name="p1" x="0.2" y="1" z="-0.8"/>
        <float name="radius" value="0.25"/>
        <bsdf type="twosided">
            <bsdf type="roughconductor">
                <string name="material" value="Au"/>
                <string name="distribution" value="ggx"/>
                <float name="alphaU" value="0.1"/>
                <float name="alphaV" value="0.2"/>
            </bsdf>
        </bsdf>
    </shape>
    <shape type="rectangle">
        <transform name="toWorld">
            <scale value="0.6"/>
            <rotate x="1" angle="90"/>
            <translate y="3"/>
        </transform>
        <emitter type="area">
            <rgb name="radiance" value="6, 6, 5"/>
        </emitter>
    </shape>
    <emitter type="spot">
        <transform name="toWorld">
            <lookAt origin="-2, 3, 2" target="0, 0, 0" up="0, 1, 0"/>
        </transform>
        <rgb name="intensity" value="20"/>
        <float name="cutoffAngle" value="25"/>
        <float name="beamWidth" value="18"/>
    </emitter>
    <emitter type="constant">
        <rgb name="radiance" value="0.1"/>
    </emitter>
</scene>
)";

constexpr const char* kNewScene = R"(<?xml version="1.0" encoding="utf-8"?>
<scene version="3.0.0">
    <integrator type="path">
        <integer name="max_depth" value="6"/>
        <integer name="rr_depth" value="4"/>
    </integrator>
    <sensor type="thinlens">
        <string name="fov_axis" value="smaller"/>
        <float name="fov" value="42"/>
        <float name="near_clip" value="0.1"/>
        <float name="aperture_radius" value="0.02"/>
        <float name="focus_distance" value="5"/>
        <transform name="to_world">
            <lookat origin="0, 1.5, 5" target="0, 0.6, 0" up="0, 1, 0"/>
        </transform>
        <sampler type="independent">
            <integer name="sample_count" value="16"/>
        </sampler>
        <film type="hdrfilm">
            <integer name="width" value="32"/>
            <integer name="height" value="24"/>
            <integer name="crop_offset_x" value="2"/>
            <integer name="crop_offset_y" value="1"/>
            <integer name="crop_width" value="28"/>
            <integer name="crop_height" value="22"/>
            <rfilter type="gaussian"/>
        </film>
    </sensor>
    <bsdf type="diffuse" id="floor">
        <texture name="reflectance" type="checkerboard">
            <rgb name="color0" value="0.6, 0.5, 0.4"/>
            <rgb name="color1" value="0.2, 0.2, 0.3"/>
            <transform name="to_uv">
                <translate x="0.125" y="0"/>
                <scale x="4" y="6"/>
            </transform>
        </texture>
    </bsdf>
    <shape type="rectangle">
        <transform name="to_world">
            <scale value="4"/>
            <rotate x="1" angle="-90"/>
        </transform>
        <ref id="floor"/>
    </shape>
    <shape type="sphere">
        <point name="center" x="-0.9" y="0.5" z="0"/>
        <float name="radius" value="0.5"/>
        <bsdf type="dielectric">
            <float name="int_ior" value="1.5"/>
            <string name="ext_ior" value="air"/>
            <rgb name="specular_transmittance" value="0.9, 1, 0.8"/>
        </bsdf>
    </shape>
    <shape type="cube">
        <transform name="to_world">
            <scale value="0.35"/>
            <rotate y="1" angle="30"/>
            <translate x="0.9" y="0.35" z="0.3"/>
        </transform>
        <bsdf type="twosided">
            <bsdf type="roughplastic">
                <rgb name="diffuse_reflectance" value="0.5, 0.1, 0.1"/>
                <float name="alpha" value="0.15"/>
                <float name="int_ior" value="1.6"/>
            </bsdf>
        </bsdf>
    </shape>
    <shape type="cylinder">
        <point name="p0" x="0.2" y="0" z="-0.8"/>
        <point name="p1" x="0.2" y="1" z="-0.8"/>
        <float name="radius" value="0.25"/>
        <bsdf type="twosided">
            <bsdf type="roughconductor">
                <string name="material" value="Au"/>
                <string name="distribution" value="ggx"/>
                <float name="alpha_u" value="0.1"/>
                <float name="alpha_v" value="0.2"/>
            </bsdf>
        </bsdf>
    </shape>
    <shape type="rectangle">
        <transform name="to_world">
            <scale value="0.6"/>
            <rotate x="1" angle="90"/>
            <translate y="3"/>
        </transform>
        <emitter type="area">
            <rgb name="radiance" value="6, 6, 5"/>
        </emitter>
    </shape>
    <emitter type="spot">
        <transform name="to_world">
            <lookat origin="-2, 3, 2" target="0, 0, 0" up="0, 1, 0"/>
        </transform>
        <rgb name="intensity" value="20"/>
        <float name="cutoff_angle" value="25"/>
        <float name="beam_width" value="18"/>
    </emitter>
    <emitter type="constant">
        <rgb name="radiance" value="0.1"/>
    </emitter>
</scene>
)";

TEST(SceneVersions, OldAndNewTwinsAreTheSameBits) {
    const test::TemporaryFolder folder;
    const test::RenderableScene oldScene(folder.write("old.xml", kOldScene)),
        newScene(folder.write("new.xml", kNewScene));
    EXPECT_EQ(newScene.width(), 28);
    EXPECT_EQ(newScene.maxDepth(), 6);
    for (const char* integrator : {"path", "mcmc_vcm"}) {
        const std::vector<float> a = oldScene.render(integrator, 8, 3), b = newScene.render(integrator, 8, 3);
        EXPECT_EQ(a, b) << integrator;
        EXPECT_NE(a, newScene.render(integrator, 8, 4)) << integrator;
        double sum = 0;
        for (const float value : b) sum += value;
        EXPECT_GT(sum / double(b.size()), 0.05) << integrator;
    }
}

}  // namespace
}  // namespace metrolux::core
